(* ltbw: how far the computed centre of a sphere can be from the true one.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   core/kernel/src/sphere.rs keeps a sphere only if three conditions on what it has computed hold. *)
Require Import Reals Psatz.
From Flocq Require Import Core.
Require Import Rounding Constants.
Open Scope R_scope.

(* The conditions, as real numbers: [n], [d] are a numerator and twice the determinant, [n'], [d']
   computed; [m] the largest difference, [l] the largest squared length and [r] the radius,
   computed. All that is left to the caller are relative errors of 2^-40: roundings of single
   operations are far below. *)
Section Centre.
Variables n d n' d' m l r s : R.
Hypothesis numerator : Rabs (n' - n) <= 205 * u * m ^ 4.
Hypothesis denominator : Rabs (d' - d) <= 94 * u * m ^ 3.
Hypothesis m_pos : 0 <= m.
Hypothesis r_pos : 0 <= r.
Definition slack : R := / 1099511627776.
Hypothesis longest : m * m <= l * (1 + slack).
(* The three conditions of the code. *)
Hypothesis not_flat : flatness * (l * r) * (1 - slack) < Rabs d'.
Hypothesis not_noise : least_square * l * (1 - slack) <= r * r.
Hypothesis not_large : s * r <= max_radius * (1 + slack).
Hypothesis s_pos : 0 <= s.
(* The quotient is at most the radius. *)
Hypothesis within_radius : Rabs (n' / d') <= r * (1 + slack).

Lemma reach_radius : m <= 205 / 100 * r.
Proof.
  destruct (Rle_or_lt m (205 / 100 * r)) as [H|H]; [exact H|exfalso].
  assert (S : 205 / 100 * r * (205 / 100 * r) <= m * m) by (apply Rmult_le_compat; lra).
  assert (Q : 205 / 100 * r * (205 / 100 * r) < m * m).
  { apply Rmult_le_0_lt_compat; lra. }
  unfold slack, flatness, least_square, max_radius in *. nra.
Qed.
Lemma d'_pos : 0 < Rabs d'.
Proof.
  apply Rle_lt_trans with (2 := not_flat).
  assert (0 <= l) by (unfold slack, flatness, least_square, max_radius in *; nra).
  apply Rmult_le_pos; [|unfold slack, flatness in *; lra]. apply Rmult_le_pos; [unfold flatness;
      lra|].
  now apply Rmult_le_pos.
Qed.
Lemma d'_large : / 32768 * (1 - 3 * slack) * (m * m * r) <= Rabs d'.
Proof.
  apply Rlt_le. apply Rle_lt_trans with (2 := not_flat).
  assert (H : m * m * r <= l * r * (1 + slack)).
  { replace (l * r * (1 + slack)) with (l * (1 + slack) * r) by ring.
    now apply Rmult_le_compat_r. }
  assert (0 <= m * m * r) by (repeat apply Rmult_le_pos; assumption).
  assert (L : 0 <= l * r) by (unfold slack, flatness, least_square, max_radius in *; nra).
  apply Rle_trans with (/ 32768 * (1 - 3 * slack) * (l * r * (1 + slack))).
  - apply Rmult_le_compat_l; [unfold slack, flatness in *; lra|exact H].
  - unfold slack, flatness in *. nra.
Qed.
Lemma cubes : m ^ 3 <= 205 / 100 * (m * m * r).
Proof.
  replace (m ^ 3) with (m * m * m) by ring.
  replace (205 / 100 * (m * m * r)) with (m * m * (205 / 100 * r)) by ring.
  apply Rmult_le_compat_l; [now apply Rmult_le_pos|exact reach_radius].
Qed.
(* The determinant is known to 2^-30. *)
Lemma denominator_relative : Rabs (d' - d) <= / 1073741824 * Rabs d'.
Proof.
  apply Rle_trans with (1 := denominator).
  pose proof cubes. pose proof d'_large.
  assert (U : u = / 9007199254740992) by (unfold u; simpl; lra).
  assert (0 <= m * m * r) by (repeat apply Rmult_le_pos; assumption).
  rewrite U. unfold slack, flatness, least_square, max_radius in *. lra.
Qed.
Lemma d_large : (1 - / 1073741824) * Rabs d' <= Rabs d.
Proof.
  pose proof denominator_relative. pose proof (Rabs_triang_inv d' (d' - d)) as T.
  replace (d' - (d' - d)) with d in T by ring. lra.
Qed.

(* In the frame, of which s is the scale: 0.53 2^-26. *)
Theorem quotient_error : s * Rabs (n' / d' - n / d) <= 53 / 100 * / 67108864.
Proof.
  pose proof d'_pos as P. pose proof d_large as L.
  assert (D : 0 < Rabs d) by (apply Rlt_le_trans with (2 := L); apply Rmult_lt_0_compat; lra).
  assert (D0 : d <> 0) by (intros E; rewrite E, Rabs_R0 in D; lra).
  assert (D1 : d' <> 0) by (intros E; rewrite E, Rabs_R0 in P; lra).
  assert (U : u = / 9007199254740992) by (unfold u; simpl; lra).
  set (v := m * m * r). assert (V0 : 0 <= v) by (unfold v; repeat apply Rmult_le_pos; assumption).
  (* The error times |d|. *)
  assert (E : Rabs (n' / d' - n / d) * Rabs d
              <= 205 * u * m ^ 4 + r * (1 + slack) * (94 * u * m ^ 3)).
  { rewrite <- Rabs_mult.
    replace ((n' / d' - n / d) * d) with ((n' - n) - n' / d' * (d' - d)) by (field; auto).
    unfold Rminus at 1. apply Rle_trans with (1 := Rabs_triang _ _). rewrite Rabs_Ropp, Rabs_mult.
    apply Rplus_le_compat; [exact numerator|].
    apply Rmult_le_compat; auto using Rabs_pos. }
  assert (F : 205 * u * m ^ 4 + r * (1 + slack) * (94 * u * m ^ 3)
              <= (515 * u) * (m * v)).
  { assert (M4 : m ^ 4 <= 205 / 100 * (m * v)).
    { replace (m ^ 4) with (m * m ^ 3) by ring.
      replace (205 / 100 * (m * v)) with (m * (205 / 100 * v)) by ring.
      apply Rmult_le_compat_l; [exact m_pos|exact cubes]. }
    replace (r * (1 + slack) * (94 * u * m ^ 3)) with (94 * (1 + slack) * u * (m * v))
      by (unfold v; ring).
    assert (0 <= m * v) by (now apply Rmult_le_pos). rewrite U. unfold slack, flatness in *. lra. }
  (* |d| is at least almost 2^-15 v. *)
  assert (G : / 32768 * (1 - / 500000000) * v <= Rabs d).
  { apply Rle_trans with (2 := L). pose proof d'_large as Q. fold v in Q.
    apply Rle_trans with ((1 - / 1073741824) * (/ 32768 * (1 - 3 * slack) * v)).
    - unfold slack, flatness in *. lra.
    - apply Rmult_le_compat_l; lra. }
  assert (H : Rabs (n' / d' - n / d) * Rabs d <= 515 * u * 32770 * m * Rabs d).
  { apply Rle_trans with (1 := E), Rle_trans with (1 := F).
    apply Rle_trans with (515 * u * 32770 * m * (/ 32768 * (1 - / 500000000) * v)).
    - assert (0 <= m * v) by (now apply Rmult_le_pos). rewrite U. lra.
    - apply Rmult_le_compat_l; [|exact G]. rewrite U. lra. }
  apply Rmult_le_reg_r in H; [|exact D].
  apply Rle_trans with (s * (515 * u * 32770 * m)); [now apply Rmult_le_compat_l|].
  pose proof reach_radius as R.
  assert (SM : s * m <= 205 / 100 * (s * r)).
  { replace (205 / 100 * (s * r)) with (s * (205 / 100 * r)) by ring.
    now apply Rmult_le_compat_l. }
  replace (s * (515 * u * 32770 * m)) with (515 * u * 32770 * (s * m)) by ring.
  rewrite U. unfold slack, flatness, least_square, max_radius in *. lra.
Qed.
End Centre.
