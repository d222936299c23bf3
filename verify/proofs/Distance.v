(* ltbw: the filter that compares two distances, core/exact/src/predicates/distance.rs.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`. *)
Require Import Reals ZArith Lia Psatz.
From Flocq Require Import Core Relative.
Require Import Rounding.
Open Scope R_scope.

Definition least : R := bpow radix2 (-1074).
Lemma u_is : u = / 9007199254740992. Proof. unfold u. simpl. lra. Qed.
Lemma least_pos : 0 < least. Proof. apply bpow_gt_0. Qed.

(* As computed, from the exact differences of floats. *)
Definition square (d : R) : R := rnd (rnd d * rnd d).
Definition squared (x y z : R) : R := rnd (rnd (square x + square y) + square z).

Lemma square_near d : mult 1074 d ->
  0 <= square d /\ d * d * ((1 - u) * (1 - u) * (1 - u)) - least <= square d
  /\ square d <= d * d * ((1 + u) * (1 + u) * (1 + u)) + least.
Proof.
  intros M. pose proof (rnd_err d M) as E. unfold square. set (f := rnd d) in *.
  assert (F : 0 <= f * f) by nra.
  pose proof (rnd_err_any (f * f)) as Q. rewrite (Rabs_pos_eq _ F) in Q. fold least in Q.
  pose proof (rnd_pos _ F) as P. set (q := rnd (f * f)) in *.
  apply Rabs_le_inv in Q. pose proof u_is as U.
  assert (A : Rabs f <= Rabs d * (1 + u)).
  { replace f with (f - d + d) by ring. pose proof (Rabs_triang (f - d) d). lra. }
  assert (B : Rabs d * (1 - u) <= Rabs f).
  { pose proof (Rabs_triang_inv d (d - f)) as T. replace (d - (d - f)) with f in T by ring.
    rewrite (Rabs_minus_sym d f) in T. lra. }
  assert (D : Rabs d * Rabs d = d * d) by (rewrite <- Rabs_mult; apply Rabs_pos_eq; nra).
  assert (G : Rabs f * Rabs f = f * f) by (rewrite <- Rabs_mult; now apply Rabs_pos_eq).
  pose proof (Rabs_pos d). pose proof (Rabs_pos f).
  assert (A2 : f * f <= d * d * ((1 + u) * (1 + u))).
  { rewrite <- D, <- G.
    replace (Rabs d * Rabs d * ((1 + u) * (1 + u)))
      with (Rabs d * (1 + u) * (Rabs d * (1 + u))) by ring.
    apply Rmult_le_compat; lra. }
  assert (B2 : d * d * ((1 - u) * (1 - u)) <= f * f).
  { rewrite <- D, <- G.
    replace (Rabs d * Rabs d * ((1 - u) * (1 - u)))
      with (Rabs d * (1 - u) * (Rabs d * (1 - u))) by ring.
    assert (0 <= Rabs d * (1 - u)) by (apply Rmult_le_pos; rewrite ?U; lra).
    apply Rmult_le_compat; lra. }
  assert (D0 : 0 <= d * d) by nra. rewrite U in *. repeat split; lra.
Qed.

Lemma square_float d : float (square d). Proof. apply float_rnd. Qed.

(* The relative error of a squared distance: five roundings. *)
Lemma squared_near x y z : mult 1074 x -> mult 1074 y -> mult 1074 z ->
  let s := x * x + y * y + z * z in
  0 <= squared x y z
  /\ s * (1 - 501 / 100 * u) - 4 * least <= squared x y z <= s * (1 + 501 / 100 * u) + 4 * least.
Proof.
  intros X Y Z s. unfold squared.
  destruct (square_near x X) as [X0 [X1 X2]]. destruct (square_near y Y) as [Y0 [Y1 Y2]].
  destruct (square_near z Z) as [Z0 [Z1 Z2]].
  assert (M : mult 1074 (square x + square y)).
  { apply mult_plus; apply float_mult, square_float. }
  pose proof (rnd_err _ M) as E.
  rewrite (Rabs_pos_eq (square x + square y)) in E by (apply Rplus_le_le_0_compat; assumption).
  assert (W0 : 0 <= rnd (square x + square y))
    by exact (rnd_pos _ (Rplus_le_le_0_compat _ _ X0 Y0)).
  set (w := rnd (square x + square y)) in *.
  assert (M2 : mult 1074 (w + square z)).
  { apply mult_plus; apply float_mult; [apply float_rnd|apply square_float]. }
  pose proof (rnd_err _ M2) as E2.
  rewrite (Rabs_pos_eq (w + square z)) in E2 by (apply Rplus_le_le_0_compat; assumption).
  assert (V0 : 0 <= rnd (w + square z)) by exact (rnd_pos _ (Rplus_le_le_0_compat _ _ W0 Z0)).
  set (v := rnd (w + square z)) in *. apply Rabs_le_inv in E, E2.
  pose proof least_pos. unfold s.
  assert (0 <= x * x) by nra. assert (0 <= y * y) by nra. assert (0 <= z * z) by nra.
  set (a := x * x) in *. set (b := y * y) in *. set (c := z * z) in *.
  set (p := square x) in *. set (q := square y) in *. set (r := square z) in *.
  clearbody p q r a b c v w s. rewrite u_is in *. clear X Y Z M M2. repeat split; lra.
Qed.

(* 2^-900 is the guard, 16 u the constant. If the computed distance of b exceeds that of a by more
   than the computed margin, it is larger. *)
Theorem nearer_correct ax ay az bx by_ bz :
  mult 1074 ax -> mult 1074 ay -> mult 1074 az -> mult 1074 bx -> mult 1074 by_ -> mult 1074 bz ->
  let a := squared ax ay az in
  let b := squared bx by_ bz in
  bpow radix2 (-900) < Rmax a b ->
  rnd (16 * u * Rmax a b) < rnd (b - a) ->
  ax * ax + ay * ay + az * az < bx * bx + by_ * by_ + bz * bz.
Proof.
  intros AX AY AZ BX BY BZ a b G H.
  destruct (squared_near ax ay az AX AY AZ) as [A0 [A1 A2]]. fold a in A0, A1, A2.
  destruct (squared_near bx by_ bz BX BY BZ) as [B0 [B1 B2]]. fold b in B0, B1, B2.
  set (sa := ax * ax + ay * ay + az * az) in *. set (sb := bx * bx + by_ * by_ + bz * bz) in *.
  destruct (Rlt_or_le sa sb) as [L|L]; [exact L|exfalso].
  set (l := Rmax a b) in *.
  assert (LA : a <= l) by apply Rmax_l. assert (LB : b <= l) by apply Rmax_r.
  assert (F : float a /\ float b) by (split; apply float_rnd). destruct F as [FA FB].
  assert (E : Rabs (rnd (b - a) - (b - a)) <= u * Rabs (b - a)).
  { apply rnd_err, mult_minus; now apply float_mult. }
  pose proof (rnd_err_any (16 * u * l)) as Q. fold least in Q.
  assert (T : 1000 * least <= u * bpow radix2 (-900)).
  { unfold u, least. rewrite <- bpow_plus. apply Rle_trans with (bpow radix2 10 * bpow radix2
      (-1074)).
    - apply Rmult_le_compat_r; [apply bpow_ge_0|simpl; lra].
    - rewrite <- bpow_plus. apply bpow_le. lia. }
  pose proof (bpow_gt_0 radix2 (-900)) as G0. set (g := bpow radix2 (-900)) in *.
  pose proof least_pos. assert (0 <= l) by lra.
  rewrite (Rabs_pos_eq (16 * u * l)) in Q by (rewrite u_is; lra).
  assert (D : b - a <= 11 * u * l + 10 * least).
  { clearbody a b l sa sb g. clear - A0 A1 A2 B0 B1 B2 L LA LB H0 H1. rewrite u_is in *. lra. }
  apply Rabs_le_inv in Q.
  assert (X : rnd (b - a) <= (11 * u * l + 10 * least) * (1 + u)).
  { destruct (Rle_or_lt 0 (b - a)) as [P|P].
    - rewrite (Rabs_pos_eq _ P) in E. apply Rabs_le_inv in E.
      apply Rle_trans with ((b - a) * (1 + u)); [lra|].
      apply Rmult_le_compat_r; [rewrite u_is; lra|exact D].
    - apply Rle_trans with 0.
      + rewrite <- (round_0 radix2 fexp ZnearestE). apply round_le; auto with typeclass_instances.
        lra.
      + rewrite u_is. lra. }
  clearbody g l. rewrite u_is in *. lra.
Qed.
