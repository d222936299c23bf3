(* ltbw: polynomials with non-negative coefficients, as bounds.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   A coefficient is a natural number of units of 2^-160. Bounds from above are rounded up, bounds
   from below down, so that everything computes with integers. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core.
Require Import Rounding.
Import ListNotations.
Open Scope R_scope.

(* Exponents of the variables 0, 1, 2, ...; missing ones are zero. *)
Definition mono := list nat.
Definition poly := list (mono * N).

Definition val (c : N) : R := IZR (Z.of_N c) * bpow radix2 (-160).

Lemma val_pos c : 0 <= val c.
Proof. apply Rmult_le_pos; [apply IZR_le; lia|apply bpow_ge_0]. Qed.
Lemma val_add a b : val (a + b) = val a + val b.
Proof. unfold val. rewrite N2Z.inj_add, plus_IZR. ring. Qed.
Lemma val_le a b : (a <= b)%N -> val a <= val b.
Proof. intros. apply Rmult_le_compat_r; [apply bpow_ge_0|apply IZR_le; lia]. Qed.
Lemma val_0 : val 0 = 0.
Proof. unfold val. simpl. ring. Qed.

(* a / 2^k, rounded up or down. *)
Definition up (k a : N) : N := N.shiftr (a + N.ones k) k.
Definition down (k a : N) : N := N.shiftr a k.

Lemma up_spec k a : (a <= up k a * 2 ^ k)%N.
Proof.
  unfold up. rewrite N.shiftr_div_pow2, N.ones_equiv.
  assert (P : (2 ^ k <> 0)%N) by (apply N.pow_nonzero; lia).
  pose proof (N.div_mod (a + N.pred (2 ^ k)) (2 ^ k) P).
  pose proof (N.mod_lt (a + N.pred (2 ^ k)) (2 ^ k) P).
  set (q := ((a + N.pred (2 ^ k)) / 2 ^ k)%N) in *. lia.
Qed.
Lemma down_spec k a : (down k a * 2 ^ k <= a)%N.
Proof.
  unfold down. rewrite N.shiftr_div_pow2.
  assert (P : (2 ^ k <> 0)%N) by (apply N.pow_nonzero; lia).
  pose proof (N.mul_div_le a (2 ^ k) P). lia.
Qed.

Lemma pow2_IZR k : IZR (Z.of_N (2 ^ k)) = bpow radix2 (Z.of_N k).
Proof. rewrite N2Z.inj_pow, <- IZR_Zpower by lia. reflexivity. Qed.

Lemma up_val k a : val a * bpow radix2 (- Z.of_N k) <= val (up k a).
Proof.
  pose proof (up_spec k a) as H. apply N2Z.inj_le, IZR_le in H.
  rewrite N2Z.inj_mul, mult_IZR, pow2_IZR in H. unfold val.
  assert (E : bpow radix2 (Z.of_N k) * bpow radix2 (- Z.of_N k) = 1).
  { rewrite <- bpow_plus, Z.add_opp_diag_r. reflexivity. }
  pose proof (bpow_gt_0 radix2 (- Z.of_N k)) as B.
  apply Rmult_le_compat_r with (r := bpow radix2 (- Z.of_N k)) in H; [|lra].
  rewrite Rmult_assoc, E, Rmult_1_r in H. pose proof (bpow_gt_0 radix2 (-160)). nra.
Qed.

(* Products of coefficients, and u times a coefficient. *)
Definition cmul (a b : N) : N := up 160 (a * b).
Definition cmul_down (a b : N) : N := down 160 (a * b).
Definition ceps (a : N) : N := up 53 a.

Lemma val_mul a b : val a * val b = val (a * b) * bpow radix2 (-160).
Proof. unfold val. rewrite N2Z.inj_mul, mult_IZR. ring. Qed.
Lemma cmul_val a b : val a * val b <= val (cmul a b).
Proof. rewrite val_mul. apply (up_val 160). Qed.
Lemma cmul_down_val a b : val (cmul_down a b) <= val a * val b.
Proof.
  rewrite val_mul. unfold cmul_down. pose proof (down_spec 160 (a * b)) as H.
  apply N2Z.inj_le, IZR_le in H. rewrite N2Z.inj_mul, mult_IZR, pow2_IZR in H.
  change (Z.of_N 160) with 160%Z in H. unfold val.
  assert (E : bpow radix2 160 * bpow radix2 (-160) = 1) by now rewrite <- bpow_plus.
  pose proof (bpow_gt_0 radix2 (-160)) as B.
  apply Rmult_le_compat_r with (r := bpow radix2 (-160)) in H; [|lra].
  rewrite Rmult_assoc, E, Rmult_1_r in H. nra.
Qed.
Lemma ceps_val a : u * val a <= val (ceps a).
Proof. rewrite Rmult_comm. apply (up_val 53). Qed.

(* Products of monomials, and their comparison. *)
Fixpoint madd (a b : mono) : mono :=
  match a, b with
  | [], _ => b
  | _, [] => a
  | i :: a', j :: b' => (i + j)%nat :: madd a' b'
  end.
Fixpoint meq (a b : mono) : bool :=
  match a, b with
  | [], [] => true
  | i :: a', j :: b' => Nat.eqb i j && meq a' b'
  | _, _ => false
  end.
Lemma meq_eq a b : meq a b = true -> a = b.
Proof.
  revert b. induction a as [|i a IH]; destruct b as [|j b]; simpl; try easy.
  intros H. apply andb_prop in H. destruct H as [H1 H2]. apply Nat.eqb_eq in H1.
  f_equal; auto.
Qed.

Definition var (t : nat) : mono := repeat 0%nat t ++ [1%nat].

(* Sums: equal monomials are joined. *)
Fixpoint ins (m : mono) (c : N) (p : poly) : poly :=
  match p with
  | [] => [(m, c)]
  | (m', c') :: p' => if meq m m' then (m', (c + c')%N) :: p' else (m', c') :: ins m c p'
  end.
Definition padd (p q : poly) : poly := fold_right (fun x acc => ins (fst x) (snd x) acc) q p.

(* Products, with coefficients multiplied by [mul]. *)
Definition pscale (mul : N -> N -> N) (m : mono) (c : N) (q : poly) : poly :=
  map (fun x => (madd m (fst x), mul c (snd x))) q.
Fixpoint pmul_with (mul : N -> N -> N) (p q : poly) : poly :=
  match p with
  | [] => []
  | (m, c) :: p' => padd (pscale mul m c q) (pmul_with mul p' q)
  end.
Definition pmul := pmul_with cmul.
Definition pmul_down := pmul_with cmul_down.
Definition peps (p : poly) : poly := map (fun x => (fst x, ceps (snd x))) p.
(* A bound from below of (1 - u) p. *)
Definition pshrink (p : poly) : poly := map (fun x => (fst x, (snd x - ceps (snd x))%N)) p.

Fixpoint peq (p q : poly) : bool :=
  match p, q with
  | [], [] => true
  | (m, c) :: p', (n, d) :: q' => meq m n && N.eqb c d && peq p' q'
  | _, _ => false
  end.
Lemma peq_eq p q : peq p q = true -> p = q.
Proof.
  revert q. induction p as [|[m c] p IH]; destruct q as [|[n d] q]; simpl; try easy.
  intros H. apply andb_prop in H. destruct H as [H H3]. apply andb_prop in H.
  destruct H as [H1 H2]. apply meq_eq in H1. apply N.eqb_eq in H2. subst. f_equal. auto.
Qed.
(* A bound of both: equal ones stay as they are. *)
Definition pboth (p q : poly) : poly := if peq p q then p else padd p q.

#[global] Arguments padd : simpl never.

Section Values.
Variable at_ : nat -> R.
Hypothesis at_pos : forall t, 0 <= at_ t.

Fixpoint mev (i : nat) (m : mono) : R :=
  match m with [] => 1 | e :: m' => at_ i ^ e * mev (S i) m' end.
Fixpoint peval (p : poly) : R :=
  match p with [] => 0 | (m, c) :: p' => val c * mev 0 m + peval p' end.

Lemma mev_pos i m : 0 <= mev i m.
Proof.
  revert i. induction m as [|e m IH]; simpl; intros i; [lra|].
  apply Rmult_le_pos; [apply pow_le, at_pos|apply IH].
Qed.
Lemma peval_pos p : 0 <= peval p.
Proof.
  induction p as [|[m c] p IH]; simpl; [lra|].
  pose proof (Rmult_le_pos _ _ (val_pos c) (mev_pos 0 m)). lra.
Qed.
Lemma mev_madd i a b : mev i (madd a b) = mev i a * mev i b.
Proof.
  revert i b. induction a as [|e a IH]; destruct b as [|e' b]; simpl; try ring.
  rewrite IH, pow_add. ring.
Qed.
Lemma mev_var t : mev 0 (var t) = at_ t.
Proof.
  unfold var. assert (G : forall k i, mev i (repeat 0%nat k ++ [1%nat]) = at_ (k + i)).
  { induction k as [|k IH]; simpl; intros i; [ring|]. rewrite IH.
    replace (k + S i)%nat with (S (k + i)) by lia. ring. }
  rewrite G. f_equal. lia.
Qed.
Lemma peval_ins m c p : peval (ins m c p) = val c * mev 0 m + peval p.
Proof.
  induction p as [|[m' c'] p IH]; simpl; [ring|].
  destruct (meq m m') eqn:E; simpl.
  - apply meq_eq in E. subst. rewrite val_add. ring.
  - rewrite IH. ring.
Qed.
Lemma peval_padd p q : peval (padd p q) = peval p + peval q.
Proof.
  unfold padd. induction p as [|[m c] p IH]; simpl; [ring|]. rewrite peval_ins, IH.
  simpl. ring.
Qed.
Lemma pscale_up mul m c q : (forall a b, val a * val b <= val (mul a b)) ->
  val c * mev 0 m * peval q <= peval (pscale mul m c q).
Proof.
  intros H. induction q as [|[n d] q IH]; simpl; [lra|]. fold (pscale mul m c q).
  rewrite mev_madd. specialize (H c d).
  pose proof (Rmult_le_pos _ _ (mev_pos 0 m) (mev_pos 0 n)). nra.
Qed.
Lemma pscale_down mul m c q : (forall a b, val (mul a b) <= val a * val b) ->
  peval (pscale mul m c q) <= val c * mev 0 m * peval q.
Proof.
  intros H. induction q as [|[n d] q IH]; simpl; [lra|]. fold (pscale mul m c q).
  rewrite mev_madd. specialize (H c d).
  pose proof (Rmult_le_pos _ _ (mev_pos 0 m) (mev_pos 0 n)). nra.
Qed.
Lemma peval_pmul p q : peval p * peval q <= peval (pmul p q).
Proof.
  induction p as [|[m c] p IH]; simpl; [lra|].
  change (pmul ((m, c) :: p) q) with (padd (pscale cmul m c q) (pmul p q)). rewrite peval_padd.
  pose proof (pscale_up cmul m c q cmul_val). lra.
Qed.
Lemma peval_pmul_down p q : peval (pmul_down p q) <= peval p * peval q.
Proof.
  induction p as [|[m c] p IH]; simpl; [lra|].
  change (pmul_down ((m, c) :: p) q) with (padd (pscale cmul_down m c q) (pmul_down p q)). rewrite
      peval_padd.
  pose proof (pscale_down cmul_down m c q cmul_down_val). lra.
Qed.
Lemma peval_peps p : u * peval p <= peval (peps p).
Proof.
  induction p as [|[m c] p IH]; simpl; [lra|]. fold (peps p).
  pose proof (ceps_val c). pose proof (mev_pos 0 m). nra.
Qed.
Lemma peval_pshrink p : peval (pshrink p) <= (1 - u) * peval p.
Proof.
  induction p as [|[m c] p IH]; simpl; [lra|]. fold (pshrink p).
  assert (val (c - ceps c) <= (1 - u) * val c).
  { destruct (N.le_gt_cases (ceps c) c) as [L|L].
    - pose proof (val_add (c - ceps c) (ceps c)) as A. rewrite N.sub_add in A by exact L.
      pose proof (ceps_val c). lra.
    - replace (c - ceps c)%N with 0%N by lia. rewrite val_0.
      pose proof u_small. pose proof (val_pos c). nra. }
  pose proof (mev_pos 0 m). nra.
Qed.
Lemma peval_pboth p q : peval p <= peval (pboth p q) /\ peval q <= peval (pboth p q).
Proof.
  unfold pboth. destruct (peq p q) eqn:E.
  - apply peq_eq in E. subst. lra.
  - rewrite peval_padd. pose proof (peval_pos p). pose proof (peval_pos q). lra.
Qed.
Lemma peval_one m : peval [(m, 2 ^ 160)%N] = mev 0 m.
Proof.
  change (val (2 ^ 160) * mev 0 m + 0 = mev 0 m).
  assert (E : val (2 ^ 160) = 1) by (unfold val; rewrite pow2_IZR; now rewrite <- bpow_plus).
  rewrite E. ring.
Qed.
End Values.
