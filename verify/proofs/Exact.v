(* ltbw: where expressions are evaluated without any error, and integers that do not overflow.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core.
Require Import Rounding Poly Expr Bound Filter.
Import ListNotations.
Open Scope R_scope.

(* The value over the integers. *)
Fixpoint exz (z : nat -> Z) (e : expr) : Z :=
  match e with
  | D n _ | X n _ => z n
  | K n _ => Z.of_N n
  | Add a b => exz z a + exz z b
  | Sub a b => exz z a - exz z b
  | Mul a b => exz z a * exz z b
  | Min a b => Z.min (exz z a) (exz z b)
  end.

(* A bound of it, if leaves are at most [l]. *)
Fixpoint magnitude (l : N) (e : expr) : N :=
  match e with
  | D _ _ | X _ _ => l
  | K n _ => n
  | Add a b | Sub a b => magnitude l a + magnitude l b
  | Mul a b => magnitude l a * magnitude l b
  | Min a b => N.max (magnitude l a) (magnitude l b)
  end.

Lemma magnitude_spec l z e : (forall n, Z.abs (z n) <= Z.of_N l)%Z ->
  (Z.abs (exz z e) <= Z.of_N (magnitude l e))%Z.
Proof.
  intros H. induction e; cbn [exz magnitude]; auto; try lia.
  rewrite Z.abs_mul, N2Z.inj_mul. apply Z.mul_le_mono_nonneg; lia.
Qed.

Fixpoint degree (e : expr) : nat :=
  match e with
  | D _ _ | X _ _ => 1
  | K _ _ => 0
  | Add a _ | Sub a _ | Min a _ => degree a
  | Mul a b => degree a + degree b
  end.
(* Summands have the same degree, constants are integers. *)
Fixpoint homogeneous (e : expr) : bool :=
  match e with
  | D _ _ | X _ _ => true
  | K _ k => N.eqb k 0
  | Add a b | Sub a b | Min a b =>
      homogeneous a && homogeneous b && Nat.eqb (degree a) (degree b)
  | Mul a b => homogeneous a && homogeneous b
  end.

(* Integers of [unit] bits for each factor: a value of degree d has to fit into unit*d bits, two's
   complement. *)
Definition fits_limbs (unit l : N) (e : expr) : bool :=
  N.ltb 0 (unit * N.of_nat (degree e)) && N.ltb (magnitude l e) (2 ^ (unit * N.of_nat (degree e) -
      1)).
Definition integers_fit (unit l : N) (e : expr) : bool :=
  homogeneous e && forallb (fits_limbs unit l) (parts e).

Theorem integers_fit_spec unit l e z : integers_fit unit l e = true ->
  (forall n, Z.abs (z n) <= Z.of_N l)%Z ->
  Forall (fun p => let w := (Z.of_N unit * Z.of_nat (degree p) - 1)%Z in
                   - 2 ^ w < exz z p < 2 ^ w)%Z (parts e).
Proof.
  unfold integers_fit. intros H L. apply andb_prop in H. destruct H as [_ H].
  apply Forall_forall. intros p I. pose proof (proj1 (forallb_forall _ _) H p I) as F.
  unfold fits_limbs in F. apply andb_prop in F. destruct F as [Z F]. apply N.ltb_lt in Z, F. pose
      proof (magnitude_spec l z p L) as M.
  apply N2Z.inj_lt in F. rewrite N2Z.inj_pow in F. cbn zeta.
  replace (Z.of_N unit * Z.of_nat (degree p) - 1)%Z
    with (Z.of_N (unit * N.of_nat (degree p) - 1))
    by (rewrite N2Z.inj_sub, N2Z.inj_mul, nat_N_Z by lia; reflexivity).
  change (Z.of_N 2) with 2%Z in F. lia.
Qed.

(* The same value in units of a power of two. *)
Lemma ex_units x z s e : homogeneous e = true -> (forall n, x n = IZR (z n) * bpow radix2 s) ->
  ex x e = IZR (exz z e) * bpow radix2 (s * Z.of_nat (degree e)).
Proof.
  intros H E. induction e; cbn [homogeneous ex exz degree] in *.
  - rewrite E. f_equal. f_equal. lia.
  - rewrite E. f_equal. f_equal. lia.
  - apply N.eqb_eq in H. subst. unfold constant. rewrite Z.mul_0_r. reflexivity.
  - apply andb_prop in H. destruct H as [H G]. apply andb_prop in H. destruct H as [H1 H2].
    apply Nat.eqb_eq in G. rewrite IHe1, IHe2, G, plus_IZR by assumption. ring.
  - apply andb_prop in H. destruct H as [H G]. apply andb_prop in H. destruct H as [H1 H2].
    apply Nat.eqb_eq in G. rewrite IHe1, IHe2, G, minus_IZR by assumption. ring.
  - apply andb_prop in H. destruct H as [H1 H2]. rewrite IHe1, IHe2, mult_IZR by assumption.
    rewrite Nat2Z.inj_add, Z.mul_add_distr_l, bpow_plus. ring.
  - apply andb_prop in H. destruct H as [H G]. apply andb_prop in H. destruct H as [H1 H2].
    apply Nat.eqb_eq in G. rewrite IHe1, IHe2, G by assumption.
    pose proof (bpow_gt_0 radix2 (s * Z.of_nat (degree e2))) as B.
    destruct (Z.min_spec (exz z e1) (exz z e2)) as [[L ->]|[L ->]];
      [apply IZR_lt in L; rewrite Rmin_left|apply IZR_le in L; rewrite Rmin_right];
      try reflexivity; apply Rmult_le_compat_r; lra.
Qed.

(* In floating point: no value is beyond 2^53 units, so that none is rounded. *)
Definition exact_within (l : N) (e : expr) : bool :=
  homogeneous e && forallb (fun p => N.leb (magnitude l p) (2 ^ 53)) (parts e).

Lemma rnd_units k e : (-1074 <= e)%Z -> (Z.abs k <= 2 ^ 53)%Z ->
  rnd (IZR k * bpow radix2 e) = IZR k * bpow radix2 e.
Proof. intros. apply round_generic; auto with typeclass_instances. now apply float_small. Qed.

Theorem exact_within_spec l e f z s : exact_within l e = true ->
  (forall n, f n = IZR (z n) * bpow radix2 s) -> (forall n, Z.abs (z n) <= Z.of_N l)%Z ->
  (-1074 <= Z.min 0 s * Z.of_nat (degree e))%Z -> fl f e = ex f e.
Proof.
  unfold exact_within. intros H F L. apply andb_prop in H. destruct H as [H P].
  induction e; intros S; cbn [fl ex]; auto; cbn [parts] in P;
    pose proof H as H'; cbn [homogeneous] in H'; cbn [forallb] in P;
    apply andb_prop in P; destruct P as [P0 P]; rewrite forallb_app in P;
    apply andb_prop in P; destruct P as [P1 P2]; apply N.leb_le in P0.
  - apply andb_prop in H'. destruct H' as [H' G]. apply andb_prop in H'.
    destruct H' as [H1 H2]. apply Nat.eqb_eq in G. cbn [degree] in S.
    rewrite IHe1, IHe2 by (auto; lia). change (ex f e1 + ex f e2) with (ex f (Add e1 e2)).
    rewrite (ex_units f z s) by auto. apply rnd_units.
    + cbn [degree]. nia.
    + pose proof (magnitude_spec l z (Add e1 e2) L). lia.
  - apply andb_prop in H'. destruct H' as [H' G]. apply andb_prop in H'.
    destruct H' as [H1 H2]. apply Nat.eqb_eq in G. cbn [degree] in S.
    rewrite IHe1, IHe2 by (auto; lia). change (ex f e1 - ex f e2) with (ex f (Sub e1 e2)).
    rewrite (ex_units f z s) by auto. apply rnd_units.
    + cbn [degree]. nia.
    + pose proof (magnitude_spec l z (Sub e1 e2) L). lia.
  - apply andb_prop in H'. destruct H' as [H1 H2]. cbn [degree] in S.
    rewrite IHe1, IHe2 by (auto; nia). change (ex f e1 * ex f e2) with (ex f (Mul e1 e2)).
    rewrite (ex_units f z s) by auto. apply rnd_units.
    + cbn [degree]. nia.
    + pose proof (magnitude_spec l z (Mul e1 e2) L). lia.
  - apply andb_prop in H'. destruct H' as [H' G]. apply andb_prop in H'.
    destruct H' as [H1 H2]. apply Nat.eqb_eq in G. cbn [degree] in S.
    rewrite IHe1, IHe2 by (auto; lia). reflexivity.
Qed.

(* A filter without parameters: coordinates are multiples of 2^s, and no computed difference is
   beyond [l] of them. *)
Definition only_differences (F : filter) : bool :=
  forallb (fun x => match x with Diff _ _ => true | Param _ => false end) (leaf_list F).
Definition check_lattice (l : N) (F : filter) : bool :=
  exact_within l (value F) && N.ltb l (2 ^ 53) && only_differences F
  && Nat.leb (degree (value F)) 5.

Theorem lattice_sound l F c k s : check_lattice l F = true -> (-194 <= s)%Z ->
  (forall i, c i = IZR (k i) * bpow radix2 s) ->
  (forall n, Rabs (computed F c n) <= IZR (Z.of_N l) * bpow radix2 s) ->
  fl_value F c = exact_value F c.
Proof.
  unfold check_lattice. intros C S E L. do 3 (apply andb_prop in C; destruct C as [C ?]).
  apply N.ltb_lt in H1. apply Nat.leb_le in H.
  set (z := fun n => match nth_error (leaf_list F) n with
                     | Some (Diff p q) => (k p - k q)%Z | _ => 0%Z end).
  assert (B : bpow radix2 s > 0) by apply bpow_gt_0.
  assert (ZX : forall n, exact F c n = IZR (z n) * bpow radix2 s).
  { intros n. unfold exact, z. destruct (nth_error (leaf_list F) n) as [[p q|p]|] eqn:N.
    - rewrite !E, minus_IZR. ring.
    - apply nth_error_In in N. apply (proj1 (forallb_forall _ _) H0) in N. discriminate.
    - ring. }
  assert (ZL : forall n, (Z.abs (z n) <= Z.of_N l)%Z).
  { intros n. destruct (Z.le_gt_cases (Z.abs (z n)) (Z.of_N l)) as [G|G]; [exact G|exfalso].
    assert (R : computed F c n = rnd (exact F c n)).
    { unfold computed, exact. destruct (nth_error (leaf_list F) n) as [[p q|p]|] eqn:N; auto.
      - apply nth_error_In in N. apply (proj1 (forallb_forall _ _) H0) in N. discriminate.
      - now rewrite round_0 by auto with typeclass_instances. }
    assert (Q : IZR (Z.of_N l + 1) * bpow radix2 s <= Rabs (computed F c n)).
    { rewrite R. apply abs_round_ge_generic; auto with typeclass_instances.
      - apply float_small; lia.
      - rewrite ZX, Rabs_mult, (Rabs_pos_eq (bpow radix2 s)) by lra. rewrite <- abs_IZR.
        apply Rmult_le_compat_r; [lra|]. apply IZR_le. lia. }
    specialize (L n). rewrite plus_IZR in Q. nra. }
  assert (CX : forall n, computed F c n = exact F c n).
  { intros n. pose proof (ZX n) as Z. unfold computed, exact in *.
    destruct (nth_error (leaf_list F) n) as [[p q|p]|]; auto.
    rewrite Z. apply rnd_units; [lia|]. specialize (ZL n). lia. }
  unfold fl_value, exact_value.
  rewrite (exact_within_spec l (value F) (computed F c) z s); auto.
  - clear - CX. induction (value F); cbn [ex]; auto; now rewrite ?IHe1, ?IHe2.
  - intros n. now rewrite CX.
  - nia.
Qed.

(* An axis without extent makes the value zero. *)
Fixpoint vanishes (F : filter) (t : nat) (e : expr) : bool :=
  match e with
  | D n _ | X n _ => member F n t
  | K _ _ => false
  | Add a b | Sub a b | Min a b => vanishes F t a && vanishes F t b
  | Mul a b => vanishes F t a || vanishes F t b
  end.
Theorem no_extent_is_zero F c t : vanishes F t (value F) = true -> only_differences F = true ->
  (forall i, float (c i)) -> sizes F 0 c t = 0 -> exact_value F c = 0.
Proof.
  intros V O C Z. unfold exact_value. induction (value F); cbn [vanishes ex] in *.
  1, 2: pose proof (member_spec F c 0 n t V) as M; rewrite Z in M;
    assert (computed F c n = 0) as K by (apply Rabs_eq_R0; pose proof (Rabs_pos (computed F c n));
      lra); clear M; unfold computed, exact in *;
    destruct (nth_error (leaf_list F) n) as [[p q|p]|] eqn:N; auto;
    apply difference_0 in K; auto; lra.
  - discriminate.
  - apply andb_prop in V. destruct V. rewrite IHe1, IHe2 by assumption. ring.
  - apply andb_prop in V. destruct V. rewrite IHe1, IHe2 by assumption. ring.
  - apply orb_prop in V. destruct V; [rewrite IHe1 by assumption|rewrite IHe2 by assumption]; ring.
  - apply andb_prop in V. destruct V. rewrite IHe1, IHe2 by assumption.
    apply Rmin_left. lra.
Qed.
