(* ltbw: expressions as the code evaluates them, and bounds of their value and error.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   One induction covers every predicate without division: |fl e| and |fl e - ex e| are at most
   polynomials in the sizes of the leaves, computed by [bounds]. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core.
Require Import Rounding Poly.
Import ListNotations.
Open Scope R_scope.

(* Leaf [n] is a rounded difference ([D]) or exact ([X]); its size is at most that of variable [t].
   [K n k] is the constant n 2^-k. *)
Inductive expr :=
  | D (n t : nat)
  | X (n t : nat)
  | K (n k : N)
  | Add (a b : expr)
  | Sub (a b : expr)
  | Mul (a b : expr)
  | Min (a b : expr).

Definition constant (n k : N) : R := IZR (Z.of_N n) * bpow radix2 (- Z.of_N k).

(* The exact value, and the computed one. *)
Fixpoint ex (x : nat -> R) (e : expr) : R :=
  match e with
  | D n _ | X n _ => x n
  | K n k => constant n k
  | Add a b => ex x a + ex x b
  | Sub a b => ex x a - ex x b
  | Mul a b => ex x a * ex x b
  | Min a b => Rmin (ex x a) (ex x b)
  end.
Fixpoint fl (f : nat -> R) (e : expr) : R :=
  match e with
  | D n _ | X n _ => f n
  | K n k => constant n k
  | Add a b => rnd (fl f a + fl f b)
  | Sub a b => rnd (fl f a - fl f b)
  | Mul a b => rnd (fl f a * fl f b)
  | Min a b => Rmin (fl f a) (fl f b)
  end.

(* Variable 0 stands for the error of gradual underflow; the others are sizes of leaves. *)
Definition eta : poly := [(var 0, (2 ^ 160)%N)].

(* Polynomials that bound |fl e| and |fl e - ex e|. *)
Fixpoint bounds (e : expr) : poly * poly :=
  match e with
  | D _ t => ([(var t, (2 ^ 160)%N)], peps [(var t, (2 ^ 160)%N)])
  | X _ t => ([(var t, (2 ^ 160)%N)], [])
  | K n k => ([([], N.shiftl n (160 - k))], [])
  | Add a b | Sub a b =>
      let (ma, ea) := bounds a in
      let (mb, eb) := bounds b in
      let m := padd ma mb in
      (padd m (peps m), padd (peps m) (padd ea eb))
  | Mul a b =>
      let (ma, ea) := bounds a in
      let (mb, eb) := bounds b in
      let m := pmul ma mb in
      let r := padd eta (peps m) in
      (padd m r, padd r (padd (pmul ma eb) (pmul (padd mb eb) ea)))
  | Min a b =>
      let (ma, ea) := bounds a in
      let (mb, eb) := bounds b in
      (pboth ma mb, pboth ea eb)
  end.

(* Constants are floats, and coefficients are exact. *)
Fixpoint sound (e : expr) : bool :=
  match e with
  | D _ _ | X _ _ => true
  | K n k => N.leb n (2 ^ 53) && N.leb k 160
  | Add a b | Sub a b | Mul a b | Min a b => sound a && sound b
  end.

(* The value is a multiple of 2^-this, if those of the leaves are multiples of 2^-q. *)
Fixpoint fraction (q : Z) (e : expr) : Z :=
  match e with
  | D _ _ | X _ _ => q
  | K _ k => Z.of_N k
  | Add a b | Sub a b | Min a b => Z.max (fraction q a) (fraction q b)
  | Mul a b => fraction q a + fraction q b
  end.

(* Every leaf is as its constructor says. *)
Fixpoint leaves (f x at_ : nat -> R) (e : expr) : Prop :=
  match e with
  | D n t => Rabs (f n) <= at_ t /\ Rabs (f n - x n) <= u * at_ t
  | X n t => Rabs (f n) <= at_ t /\ f n = x n
  | K _ _ => True
  | Add a b | Sub a b | Mul a b | Min a b => leaves f x at_ a /\ leaves f x at_ b
  end.

Lemma Rmin_err a b a' b' d e r : Rabs (a - a') <= d -> Rabs (b - b') <= e -> d <= r -> e <= r ->
  Rabs (Rmin a b - Rmin a' b') <= r.
Proof.
  intros. apply Rabs_le_inv in H. apply Rabs_le_inv in H0. apply Rabs_le.
  unfold Rmin. destruct (Rle_dec a b), (Rle_dec a' b'); lra.
Qed.
Lemma Rmin_abs a b d e r : Rabs a <= d -> Rabs b <= e -> d <= r -> e <= r ->
  Rabs (Rmin a b) <= r.
Proof. intros. unfold Rmin. destruct (Rle_dec a b); lra. Qed.

Section Bounds.
Variable f x at_ : nat -> R.
Hypothesis at_pos : forall t, 0 <= at_ t.
Hypothesis f_float : forall n, float (f n).
(* Either underflow costs at most variable 0, or there is none, for all are multiples of 2^-q. *)
Variable q : Z.
Hypothesis q_pos : (0 <= q)%Z.
Hypothesis regime :
  at_ 0%nat = bpow radix2 (-1074) \/ at_ 0%nat = 0 /\ forall n, mult q (f n).

Notation P := (peval at_).

Lemma fl_float e : sound e = true -> float (fl f e).
Proof.
  induction e; simpl; intros H; try apply float_rnd; auto.
  - apply andb_prop in H. destruct H as [H1 H2]. apply N.leb_le in H1, H2.
    apply float_small; lia.
  - apply andb_prop in H. destruct H. unfold Rmin. destruct (Rle_dec _ _); auto.
Qed.

Lemma fraction_pos e : (0 <= fraction q e)%Z.
Proof. induction e; simpl; lia. Qed.

Lemma fl_fraction e : (forall n, mult q (f n)) -> mult (fraction q e) (fl f e).
Proof.
  intros F. induction e; simpl; auto.
  - apply mult_spec. now exists (Z.of_N n).
  - apply mult_rnd, mult_plus; eapply mult_weaken; [|exact IHe1| |exact IHe2]; lia.
  - apply mult_rnd, mult_minus; eapply mult_weaken; [|exact IHe1| |exact IHe2]; lia.
  - now apply mult_rnd, mult_mul.
  - unfold Rmin. destruct (Rle_dec _ _); eapply mult_weaken;
      [|exact IHe1| |exact IHe2]; lia.
Qed.

(* No underflow: either it is accounted for, or the value is no fraction of 2^-1074. *)
Definition fine e := at_ 0%nat = 0 -> (fraction q e <= 1074)%Z.

Lemma product_err a b : fine (Mul a b) ->
  Rabs (rnd (fl f a * fl f b) - fl f a * fl f b) <= u * Rabs (fl f a * fl f b) + at_ 0%nat.
Proof.
  intros H. destruct regime as [E|[E F]].
  - rewrite E. apply rnd_err_any.
  - rewrite E, Rplus_0_r. apply rnd_err. specialize (H E). simpl in H.
    eapply mult_weaken; [exact H|]. apply mult_mul; now apply fl_fraction.
Qed.

Lemma sum_err p r : float p -> float r -> Rabs (rnd (p + r) - (p + r)) <= u * Rabs (p + r).
Proof. intros. apply rnd_err, mult_plus; now apply float_mult. Qed.
Lemma difference_err' p r : float p -> float r ->
  Rabs (rnd (p - r) - (p - r)) <= u * Rabs (p - r).
Proof. intros. apply rnd_err, mult_minus; now apply float_mult. Qed.

Lemma peval_eta : P eta = at_ 0%nat.
Proof. unfold eta. rewrite peval_one. apply mev_var. Qed.
Lemma peval_var t : P [(var t, (2 ^ 160)%N)] = at_ t.
Proof. rewrite peval_one. apply mev_var. Qed.

Lemma constant_pos n k : 0 <= constant n k.
Proof. apply Rmult_le_pos; [apply IZR_le; lia|apply bpow_ge_0]. Qed.

Lemma peval_constant n k : (k <= 160)%N -> P [([], N.shiftl n (160 - k))] = constant n k.
Proof.
  intros H. cbn [peval mev]. unfold val, constant. rewrite N.shiftl_mul_pow2, N2Z.inj_mul.
  rewrite mult_IZR, pow2_IZR, N2Z.inj_sub by lia.
  rewrite Rmult_1_r, Rplus_0_r, Rmult_assoc, <- bpow_plus.
  now replace (Z.of_N 160 - Z.of_N k + -160)%Z with (- Z.of_N k)%Z by lia.
Qed.

Theorem bounded e : sound e = true -> leaves f x at_ e -> fine e ->
  Rabs (fl f e) <= P (fst (bounds e)) /\ Rabs (fl f e - ex x e) <= P (snd (bounds e)).
Proof.
  pose proof u_pos as U. pose proof at_pos as A.
  induction e; intros S L F; cbn [bounds].
  - destruct L as [L1 L2]. cbn [fst snd fl ex].
    pose proof (peval_peps at_ A [(var t, (2 ^ 160)%N)]) as E. rewrite peval_var in E.
    rewrite peval_var. split; [exact L1|exact (Rle_trans _ _ _ L2 E)].
  - destruct L as [L1 L2]. cbn [fst snd fl ex]. rewrite peval_var. split; [exact L1|].
    rewrite L2, Rminus_diag_eq, Rabs_R0 by reflexivity. simpl. lra.
  - cbn [sound] in S. apply andb_prop in S. destruct S as [_ S]. apply N.leb_le in S.
    cbn [fst snd fl ex]. split.
    + rewrite Rabs_pos_eq by apply constant_pos. apply Req_le. symmetry.
      now apply peval_constant.
    + rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. apply Rle_refl.
  - simpl in S. apply andb_prop in S. destruct S as [S1 S2]. destruct L as [L1 L2].
    destruct (IHe1 S1 L1) as [M1 E1]. { intros Z. specialize (F Z). simpl in F. lia. }
    destruct (IHe2 S2 L2) as [M2 E2]. { intros Z. specialize (F Z). simpl in F. lia. }
    destruct (bounds e1) as [ma ea]. destruct (bounds e2) as [mb eb]. cbn [fst snd fl ex] in *.
    pose proof (sum_err _ _ (fl_float e1 S1) (fl_float e2 S2)) as R.
    pose proof (peval_peps at_ A (padd ma mb)) as Q. rewrite !peval_padd in *.
    set (a := fl f e1) in *. set (b := fl f e2) in *.
    assert (T : Rabs (a + b) <= P ma + P mb) by (pose proof (Rabs_triang a b); lra).
    assert (T' : Rabs (rnd (a + b) - (a + b)) <= P (peps (padd ma mb))).
    { apply Rle_trans with (1 := R), Rle_trans with (2 := Q).
      apply Rmult_le_compat_l; [now apply Rlt_le|exact T]. }
    split.
    + replace (rnd (a + b)) with (rnd (a + b) - (a + b) + (a + b)) by ring.
      pose proof (Rabs_triang (rnd (a + b) - (a + b)) (a + b)). lra.
    + replace (rnd (a + b) - (ex x e1 + ex x e2))
        with (rnd (a + b) - (a + b) + ((a - ex x e1) + (b - ex x e2))) by ring.
      pose proof (Rabs_triang (rnd (a + b) - (a + b)) ((a - ex x e1) + (b - ex x e2))).
      pose proof (Rabs_triang (a - ex x e1) (b - ex x e2)). lra.
  - simpl in S. apply andb_prop in S. destruct S as [S1 S2]. destruct L as [L1 L2].
    destruct (IHe1 S1 L1) as [M1 E1]. { intros Z. specialize (F Z). simpl in F. lia. }
    destruct (IHe2 S2 L2) as [M2 E2]. { intros Z. specialize (F Z). simpl in F. lia. }
    destruct (bounds e1) as [ma ea]. destruct (bounds e2) as [mb eb]. cbn [fst snd fl ex] in *.
    pose proof (difference_err' _ _ (fl_float e1 S1) (fl_float e2 S2)) as R.
    pose proof (peval_peps at_ A (padd ma mb)) as Q. rewrite !peval_padd in *.
    set (a := fl f e1) in *. set (b := fl f e2) in *.
    assert (T : Rabs (a - b) <= P ma + P mb).
    { pose proof (Rabs_triang a (- b)) as T. rewrite Rabs_Ropp in T. unfold Rminus. lra. }
    assert (T' : Rabs (rnd (a - b) - (a - b)) <= P (peps (padd ma mb))).
    { apply Rle_trans with (1 := R), Rle_trans with (2 := Q).
      apply Rmult_le_compat_l; [now apply Rlt_le|exact T]. }
    split.
    + replace (rnd (a - b)) with (rnd (a - b) - (a - b) + (a - b)) by ring.
      pose proof (Rabs_triang (rnd (a - b) - (a - b)) (a - b)). lra.
    + replace (rnd (a - b) - (ex x e1 - ex x e2))
        with (rnd (a - b) - (a - b) + ((a - ex x e1) + - (b - ex x e2))) by ring.
      pose proof (Rabs_triang (rnd (a - b) - (a - b)) ((a - ex x e1) + - (b - ex x e2))).
      pose proof (Rabs_triang (a - ex x e1) (- (b - ex x e2))) as T2.
      rewrite Rabs_Ropp in T2. lra.
  - simpl in S. apply andb_prop in S. destruct S as [S1 S2]. destruct L as [L1 L2].
    pose proof (fraction_pos e1). pose proof (fraction_pos e2).
    destruct (IHe1 S1 L1) as [M1 E1]. { intros Z. specialize (F Z). simpl in F. lia. }
    destruct (IHe2 S2 L2) as [M2 E2]. { intros Z. specialize (F Z). simpl in F. lia. }
    pose proof (product_err e1 e2 F) as R.
    destruct (bounds e1) as [ma ea]. destruct (bounds e2) as [mb eb]. cbn [fst snd fl ex] in *.
    pose proof (peval_peps at_ A (pmul ma mb)) as Q.
    pose proof (peval_pmul at_ A ma mb) as Q1. pose proof (peval_pmul at_ A ma eb) as Q2.
    pose proof (peval_pmul at_ A (padd mb eb) ea) as Q3.
    rewrite !peval_padd in *. rewrite peval_eta.
    set (a := fl f e1) in *. set (b := fl f e2) in *.
    assert (T : Rabs (a * b) <= P (pmul ma mb)).
    { rewrite Rabs_mult. eapply Rle_trans; [|exact Q1].
      apply Rmult_le_compat; auto using Rabs_pos. }
    assert (T' : Rabs (rnd (a * b) - a * b) <= at_ 0%nat + P (peps (pmul ma mb))).
    { apply Rle_trans with (1 := R). rewrite Rplus_comm. apply Rplus_le_compat_l.
      apply Rle_trans with (2 := Q). apply Rmult_le_compat_l; [now apply Rlt_le|exact T]. }
    split.
    + replace (rnd (a * b)) with (rnd (a * b) - a * b + a * b) by ring.
      pose proof (Rabs_triang (rnd (a * b) - a * b) (a * b)). lra.
    + replace (rnd (a * b) - ex x e1 * ex x e2)
        with (rnd (a * b) - a * b + (a * (b - ex x e2) + ex x e2 * (a - ex x e1))) by ring.
      pose proof (Rabs_triang (rnd (a * b) - a * b)
                    (a * (b - ex x e2) + ex x e2 * (a - ex x e1))).
      pose proof (Rabs_triang (a * (b - ex x e2)) (ex x e2 * (a - ex x e1))) as T2.
      rewrite !Rabs_mult in T2.
      assert (B : Rabs (ex x e2) <= P mb + P eb).
      { replace (ex x e2) with (b + - (b - ex x e2)) by ring.
        pose proof (Rabs_triang b (- (b - ex x e2))) as T3. rewrite Rabs_Ropp in T3. lra. }
      pose proof (Rmult_le_compat _ _ _ _ (Rabs_pos _) (Rabs_pos _) M1 E2).
      pose proof (Rmult_le_compat _ _ _ _ (Rabs_pos _) (Rabs_pos _) B E1). lra.
  - simpl in S. apply andb_prop in S. destruct S as [S1 S2]. destruct L as [L1 L2].
    destruct (IHe1 S1 L1) as [M1 E1]. { intros Z. specialize (F Z). simpl in F. lia. }
    destruct (IHe2 S2 L2) as [M2 E2]. { intros Z. specialize (F Z). simpl in F. lia. }
    destruct (bounds e1) as [ma ea]. destruct (bounds e2) as [mb eb]. cbn [fst snd fl ex] in *.
    pose proof (peval_pboth at_ A ma mb) as [Q1 Q2].
    pose proof (peval_pboth at_ A ea eb) as [Q3 Q4]. split.
    + eapply Rmin_abs; eassumption.
    + eapply Rmin_err; eassumption.
Qed.
End Bounds.
