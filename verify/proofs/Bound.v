(* ltbw: error bounds as computed, from below, and when one polynomial dominates another.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core Relative.
Require Import Rounding Poly Expr.
Import ListNotations.
Open Scope R_scope.

(* A bound is an expression of constants, sums, products and exact leaves [X t t]: variables. *)
Fixpoint is_bound (b : expr) : bool :=
  match b with
  | X n t => Nat.eqb n t
  | K n _ => N.ltb 0 n
  | Add a b | Mul a b => is_bound a && is_bound b
  | _ => false
  end.

(* A polynomial that is nowhere above the computed value. *)
Fixpoint lower (b : expr) : poly :=
  match b with
  | X _ t => [(var t, (2 ^ 160)%N)]
  | K n k => [([], N.shiftl n (160 - k))]
  | Add a b => pshrink (padd (lower a) (lower b))
  | Mul a b => pshrink (pmul_down (lower a) (lower b))
  | _ => []
  end.

(* The computed value is at least 2^this, if variable t is at least 2^(low t). *)
Fixpoint least (low : nat -> Z) (b : expr) : Z :=
  match b with
  | X _ t => low t
  | K n k => Z.log2 (Z.of_N n) - Z.of_N k
  | Add a b => Z.max (least low a) (least low b)
  | Mul a b => least low a + least low b
  | _ => 0
  end.
(* No product falls below the normal range. *)
Fixpoint normal (low : nat -> Z) (b : expr) : bool :=
  match b with
  | X _ t => Z.leb (-1074) (low t)
  | K n k => Z.leb (-1022) (Z.log2 (Z.of_N n) - Z.of_N k)
  | Add a b => normal low a && normal low b
  | Mul a b =>
      normal low a && normal low b && Z.leb (-1022) (least low a + least low b)
  | _ => false
  end.

Lemma rnd_from_below z : 0 <= z -> Rabs (rnd z - z) <= u * Rabs z -> (1 - u) * z <= rnd z.
Proof. intros P E. rewrite (Rabs_pos_eq z P) in E. apply Rabs_le_inv in E. lra. Qed.

Section Lower.
Variable at_ : nat -> R.
Hypothesis at_pos : forall t, 0 <= at_ t.
Hypothesis at_float : forall t, float (at_ t).
Notation P := (peval at_).

Lemma fl_pos b : is_bound b = true -> 0 <= fl at_ b.
Proof.
  induction b; simpl; intros H; try easy; try apply at_pos.
  - apply constant_pos.
  - apply andb_prop in H. destruct H. apply rnd_pos. pose proof (IHb1 H).
    pose proof (IHb2 H0). lra.
  - apply andb_prop in H. destruct H. apply rnd_pos, Rmult_le_pos; auto.
Qed.

(* Every product that the bound computes has a small relative error. *)
Fixpoint precise (b : expr) : Prop :=
  match b with
  | Add a b => precise a /\ precise b
  | Mul a b => precise a /\ precise b /\
      Rabs (rnd (fl at_ a * fl at_ b) - fl at_ a * fl at_ b) <= u * Rabs (fl at_ a * fl at_ b)
  | _ => True
  end.

Theorem lower_bound b : sound b = true -> is_bound b = true -> precise b ->
  P (lower b) <= fl at_ b.
Proof.
  pose proof u_small as U. pose proof u_pos as U'.
  induction b; intros S B R; try discriminate B; cbn [lower fl].
  - cbn [is_bound] in B. apply Nat.eqb_eq in B. subst.
    rewrite peval_var. apply Rle_refl.
  - cbn [sound] in S. apply andb_prop in S. destruct S as [_ S]. apply N.leb_le in S.
    apply Req_le. now apply peval_constant.
  - cbn [sound] in S. apply andb_prop in S. destruct S as [S1 S2].
    pose proof B as B'. cbn [is_bound] in B'. apply andb_prop in B'. destruct B' as [B1 B2].
    destruct R as [R1 R2]. specialize (IHb1 S1 B1 R1). specialize (IHb2 S2 B2 R2).
    eapply Rle_trans; [apply peval_pshrink; exact at_pos|]. rewrite peval_padd.
    pose proof (fl_pos b1 B1). pose proof (fl_pos b2 B2).
    apply Rle_trans with ((1 - u) * (fl at_ b1 + fl at_ b2)).
    + apply Rmult_le_compat_l; lra.
    + apply rnd_from_below; [lra|]. apply sum_err; apply fl_float; auto.
  - cbn [sound] in S. apply andb_prop in S. destruct S as [S1 S2].
    pose proof B as B'. cbn [is_bound] in B'. apply andb_prop in B'. destruct B' as [B1 B2].
    destruct R as [R1 [R2 E]]. specialize (IHb1 S1 B1 R1). specialize (IHb2 S2 B2 R2).
    eapply Rle_trans; [apply peval_pshrink; exact at_pos|].
    pose proof (peval_pmul_down at_ at_pos (lower b1) (lower b2)) as D.
    pose proof (peval_pos at_ at_pos (lower b1)). pose proof (peval_pos at_ at_pos (lower b2)).
    pose proof (Rmult_le_compat _ _ _ _ H H0 IHb1 IHb2) as M.
    pose proof (fl_pos b1 B1). pose proof (fl_pos b2 B2).
    apply Rle_trans with ((1 - u) * (fl at_ b1 * fl at_ b2)).
    + apply Rmult_le_compat_l; lra.
    + apply rnd_from_below; [now apply Rmult_le_pos|exact E].
Qed.

(* In the exactness window: everything is a multiple of 2^-1074. *)
Lemma precise_window q b : (0 <= q)%Z -> (forall t, mult q (at_ t)) ->
  (fraction q b <= 1074)%Z -> precise b.
Proof.
  intros Q M. induction b; intros F; simpl in *; auto.
  - split; [apply IHb1|apply IHb2]; lia.
  - pose proof (fraction_pos q Q b1). pose proof (fraction_pos q Q b2).
    split; [apply IHb1; lia|]. split; [apply IHb2; lia|].
    apply rnd_err. eapply mult_weaken; [exact F|]. apply mult_mul; now apply fl_fraction.
Qed.

(* Under the guard: everything is normal. *)
Variable low : nat -> Z.

(* Every variable of the expression is above its lower limit. *)
Fixpoint above (b : expr) : Prop :=
  match b with
  | X _ t | D _ t => bpow radix2 (low t) <= at_ t
  | K _ _ => True
  | Add a b | Sub a b | Mul a b | Min a b => above a /\ above b
  end.

Lemma least_normal b : normal low b = true -> (-1074 <= least low b)%Z.
Proof.
  induction b; simpl; intros H; try easy.
  - now apply Z.leb_le.
  - apply Z.leb_le in H. lia.
  - apply andb_prop in H. destruct H. specialize (IHb1 H). lia.
  - apply andb_prop in H. destruct H. apply Z.leb_le in H0. lia.
Qed.

Lemma least_fl b : is_bound b = true -> normal low b = true -> above b ->
  bpow radix2 (least low b) <= fl at_ b.
Proof.
  induction b; intros B N A; try discriminate B; cbn [least fl].
  - cbn [is_bound] in B. apply Nat.eqb_eq in B. subst. exact A.
  - cbn [is_bound] in B. apply N.ltb_lt in B. unfold constant. unfold Z.sub.
    rewrite bpow_plus. apply Rmult_le_compat_r; [apply bpow_ge_0|].
    rewrite <- IZR_Zpower by apply Z.log2_nonneg. apply IZR_le.
    apply Z.log2_spec. lia.
  - pose proof (least_normal _ N) as L. cbn [is_bound] in B. cbn [normal] in N.
    apply andb_prop in B. destruct B as [B1 B2]. apply andb_prop in N. destruct N as [N1 N2].
    destruct A as [A1 A2]. cbn [least] in L.
    apply round_ge_generic; auto with typeclass_instances; [now apply float_bpow|].
    pose proof (IHb1 B1 N1 A1). pose proof (IHb2 B2 N2 A2).
    pose proof (fl_pos _ B1). pose proof (fl_pos _ B2).
    destruct (Z.max_spec (least low b1) (least low b2)) as [[_ ->]|[_ ->]]; lra.
  - pose proof (least_normal _ N) as L. cbn [is_bound] in B. cbn [normal] in N.
    apply andb_prop in B. destruct B as [B1 B2]. apply andb_prop in N. destruct N as [N N3].
    apply andb_prop in N. destruct N as [N1 N2]. destruct A as [A1 A2]. cbn [least] in L.
    apply round_ge_generic; auto with typeclass_instances; [now apply float_bpow|].
    rewrite bpow_plus. apply Rmult_le_compat; auto using bpow_ge_0.
Qed.

Lemma precise_guard b : is_bound b = true -> normal low b = true -> above b -> precise b.
Proof.
  induction b; intros B N A; try discriminate B; simpl; auto.
  - cbn [is_bound] in B. cbn [normal] in N.
    apply andb_prop in B. destruct B as [B1 B2]. apply andb_prop in N. destruct N as [N1 N2].
    destruct A as [A1 A2]. auto.
  - cbn [is_bound] in B. cbn [normal] in N.
    apply andb_prop in B. destruct B as [B1 B2]. apply andb_prop in N. destruct N as [N N3].
    apply andb_prop in N. destruct N as [N1 N2]. destruct A as [A1 A2].
    split; [auto|]. split; [auto|]. apply Z.leb_le in N3.
    assert (E := relative_error_N_FLT radix2 emin prec eq_refl (fun z => negb (Z.even z))
                   (fl at_ b1 * fl at_ b2)).
    rewrite half_u in E. apply E.
    rewrite Rabs_pos_eq by (apply Rmult_le_pos; now apply fl_pos).
    apply Rle_trans with (bpow radix2 (least low b1 + least low b2)).
    + apply bpow_le. exact N3.
    + rewrite bpow_plus. apply Rmult_le_compat; auto using bpow_ge_0, least_fl.
Qed.

(* The weight of what [b] has more than [a], if it has no less of anything. *)
Fixpoint whole (i : nat) (b : mono) : Z :=
  match b with [] => 0 | e :: b' => whole (S i) b' + Z.of_nat e * low i end.
Fixpoint excess (i : nat) (a b : mono) : option Z :=
  match a, b with
  | [], _ => Some (whole i b)
  | _, [] => None
  | e :: a', e' :: b' =>
      if Nat.leb e e' then
        match excess (S i) a' b' with
        | Some s => Some (s + Z.of_nat (e' - e) * low i)%Z
        | None => None
        end
      else None
  end.

(* Variable i and all after it are above their limits, if [e] of them are positive. *)
Lemma pow_above i e : bpow radix2 (low i) <= at_ i \/ e = O ->
  bpow radix2 (Z.of_nat e * low i) <= at_ i ^ e.
Proof.
  intros [H | ->]; [|simpl; lra].
  induction e as [|e IH]; [simpl; lra|].
  replace (Z.of_nat (S e) * low i)%Z with (low i + Z.of_nat e * low i)%Z by lia.
  rewrite bpow_plus. simpl. apply Rmult_le_compat; auto using bpow_ge_0.
Qed.

(* The variables that are positive in [b] are above their limits. *)
Fixpoint all_above (i : nat) (b : mono) : Prop :=
  match b with
  | [] => True
  | e :: b' => (bpow radix2 (low i) <= at_ i \/ e = O) /\ all_above (S i) b'
  end.

Lemma whole_spec b : forall i, all_above i b -> bpow radix2 (whole i b) <= mev at_ i b.
Proof.
  induction b as [|e b IH]; intros i A; [simpl; lra|]. destruct A as [A1 A2].
  cbn [whole mev]. rewrite bpow_plus, Rmult_comm.
  apply Rmult_le_compat; auto using bpow_ge_0. now apply pow_above.
Qed.
Lemma excess_spec b : forall i a s, all_above i b -> excess i a b = Some s ->
  bpow radix2 s * mev at_ i a <= mev at_ i b.
Proof.
  induction b as [|e' b IH]; intros i a s A E.
  - destruct a; simpl in E; inversion E. simpl. lra.
  - pose proof A as A'. destruct A as [A1 A2]. destruct a as [|e a]; cbn [excess] in E.
    + inversion E. cbn [mev]. rewrite Rmult_1_r. now apply (whole_spec (e' :: b)).
    + destruct (Nat.leb e e') eqn:L; [|discriminate]. apply Nat.leb_le in L.
      destruct (excess (S i) a b) as [s'|] eqn:E'; [|discriminate]. inversion E. subst s.
      specialize (IH _ _ _ A2 E'). cbn [mev].
      replace (at_ i ^ e') with (at_ i ^ (e' - e) * at_ i ^ e)
        by (rewrite <- pow_add; f_equal; lia).
      rewrite bpow_plus.
      assert (H : bpow radix2 (Z.of_nat (e' - e) * low i) <= at_ i ^ (e' - e)).
      { apply pow_above. destruct A1 as [A1 | ->]; [now left|right; lia]. }
      pose proof (pow_le (at_ i) e (at_pos i)) as W.
      pose proof (mev_pos at_ at_pos (S i) a) as W2.
      pose proof (bpow_ge_0 radix2 s'). pose proof (bpow_ge_0 radix2 (Z.of_nat (e' - e) * low i)).
      replace (bpow radix2 s' * bpow radix2 (Z.of_nat (e' - e) * low i)
               * (at_ i ^ e * mev at_ (S i) a))
        with (bpow radix2 (Z.of_nat (e' - e) * low i) * at_ i ^ e
              * (bpow radix2 s' * mev at_ (S i) a)) by ring.
      apply Rmult_le_compat; auto using Rmult_le_pos.
      apply Rmult_le_compat_r; auto.
Qed.

(* A term with underflow (variable 0 is then 2^-1074) becomes part of the first of [targets] that
   has everything else in it. *)
Fixpoint find (rest : mono) (targets : poly) : option (mono * Z) :=
  match targets with
  | [] => None
  | (m, _) :: targets' =>
      match m with
      | O :: m' =>
          match excess 1 rest m' with Some s => Some (m, s) | None => find rest targets' end
      | _ => find rest targets'
      end
  end.
Definition settle (targets : poly) (x : mono * N) : mono * N :=
  match x with
  | (S e :: rest, c) =>
      match find rest targets with
      | Some (m, s) =>
          let w := (1074 * Z.of_nat (S e) + s)%Z in
          if Z.leb 0 w then (m, up (Z.to_N w) c) else x
      | None => x
      end
  | _ => x
  end.

Definition targets_above (targets : poly) :=
  Forall (fun x => match fst x with O :: m' => all_above 1 m' | _ => True end) targets.

Lemma find_spec rest targets m s : targets_above targets -> find rest targets = Some (m, s) ->
  bpow radix2 s * mev at_ 1 rest <= mev at_ 0 m.
Proof.
  induction targets as [|[n c] targets IH]; simpl; [easy|]. intros A.
  inversion A as [|? ? A1 A2]. subst. specialize (IH A2). destruct n as [|[|e] n]; auto.
  destruct (excess 1 rest n) eqn:E; auto. intros H. inversion H. subst. simpl.
  rewrite Rmult_1_l. now apply excess_spec.
Qed.

Lemma settle_spec targets x :
  at_ 0%nat = 0 \/ at_ 0%nat = bpow radix2 (-1074) /\ targets_above targets ->
  val (snd x) * mev at_ 0 (fst x)
    <= val (snd (settle targets x)) * mev at_ 0 (fst (settle targets x)).
Proof.
  destruct x as [[|[|e] rest] c]; intros R; cbn [fst snd settle]; try apply Rle_refl.
  destruct (find rest targets) as [[m s]|] eqn:F; [|apply Rle_refl].
  destruct (Z.leb _ _) eqn:W; [|apply Rle_refl]. apply Z.leb_le in W. cbn [fst snd].
  destruct R as [R|[R A]].
  - cbn [mev]. rewrite R. simpl pow. rewrite Rmult_0_l, Rmult_0_l, Rmult_0_r.
    apply Rmult_le_pos; [apply val_pos|]. now apply mev_pos.
  - pose proof (find_spec _ _ _ _ A F) as H. cbn [mev]. rewrite R.
    set (w := (1074 * Z.of_nat (S e) + s)%Z) in *.
    pose proof (up_val (Z.to_N w) c) as V. rewrite Z2N.id in V by exact W.
    assert (Q : bpow radix2 (-1074) ^ S e = bpow radix2 (- w) * bpow radix2 s).
    { rewrite <- bpow_plus. unfold w.
      assert (G : forall k, bpow radix2 (-1074) ^ k = bpow radix2 (- (1074 * Z.of_nat k))).
      { induction k as [|k IH]; [reflexivity|].
        replace (- (1074 * Z.of_nat (S k)))%Z with (-1074 + - (1074 * Z.of_nat k))%Z by lia.
        rewrite bpow_plus, <- IH. reflexivity. }
      rewrite G. f_equal. lia. }
    rewrite Q. pose proof (val_pos c). pose proof (bpow_ge_0 radix2 (- w)).
    pose proof (mev_pos at_ at_pos 0 m). pose proof (mev_pos at_ at_pos 1 rest).
    pose proof (bpow_ge_0 radix2 s).
    replace (val c * (bpow radix2 (- w) * bpow radix2 s * mev at_ 1 rest))
      with (val c * bpow radix2 (- w) * (bpow radix2 s * mev at_ 1 rest)) by ring.
    apply Rmult_le_compat; auto using Rmult_le_pos.
Qed.

Lemma settle_all targets p :
  at_ 0%nat = 0 \/ at_ 0%nat = bpow radix2 (-1074) /\ targets_above targets ->
  P p <= P (map (settle targets) p).
Proof.
  intros R. induction p as [|[m c] p IH]; [apply Rle_refl|].
  change (map (settle targets) ((m, c) :: p))
    with (settle targets (m, c) :: map (settle targets) p).
  pose proof (settle_spec targets (m, c) R) as S. destruct (settle targets (m, c)) as [m' c'].
  cbn [peval fst snd] in *. lra.
Qed.
End Lower.

(* Takes the terms of [p] from those of [q] one by one. *)
Fixpoint take (m : mono) (c : N) (q : poly) : option poly :=
  match q with
  | [] => None
  | (m', c') :: q' =>
      if meq m m' then if N.leb c c' then Some ((m', (c' - c)%N) :: q') else None
      else match take m c q' with Some r => Some ((m', c') :: r) | None => None end
  end.
Fixpoint covered (p q : poly) : bool :=
  match p with
  | [] => true
  | (m, c) :: p' => match take m c q with Some r => covered p' r | None => false end
  end.

Lemma take_spec at_ m c q r : take m c q = Some r ->
  peval at_ q = val c * mev at_ 0 m + peval at_ r.
Proof.
  revert r. induction q as [|[m' c'] q IH]; intros r; cbn [take]; [easy|].
  destruct (meq m m') eqn:E.
  - apply meq_eq in E. subst. destruct (N.leb c c') eqn:L; [|easy]. apply N.leb_le in L.
    intros H. inversion H. cbn [peval].
    replace (val c') with (val (c' - c) + val c); [ring|].
    rewrite <- val_add. f_equal. lia.
  - destruct (take m c q) as [r'|]; [|easy]. intros H. inversion H. cbn [peval].
    rewrite (IH _ eq_refl). ring.
Qed.
Lemma covered_spec at_ (at_pos : forall t, 0 <= at_ t) p q :
  covered p q = true -> peval at_ p <= peval at_ q.
Proof.
  revert q. induction p as [|[m c] p IH]; intros q; cbn [covered]; intros H.
  - apply (peval_pos at_ at_pos).
  - destruct (take m c q) as [r|] eqn:T; [|discriminate].
    rewrite (take_spec at_ _ _ _ _ T). cbn [peval]. specialize (IH _ H). lra.
Qed.

(* Overflow: an integer above 2^160 times the polynomial, if variable t is at most 2^(high t). *)
Fixpoint weight (high : nat -> Z) (i : nat) (m : mono) : Z :=
  match m with [] => 0 | e :: m' => Z.of_nat e * high i + weight high (S i) m' end.
Fixpoint size (high : nat -> Z) (p : poly) : Z :=
  match p with
  | [] => 0
  | (m, c) :: p' => Z.shiftl (Z.of_N c) (weight high 0 m) + size high p'
  end.
Definition fits (high : nat -> Z) (p : poly) : bool :=
  Z.ltb (size high p) (Z.shiftl 1 (1024 + 160)).
Fixpoint all_fit (high : nat -> Z) (e : expr) : bool :=
  fits high (fst (bounds e)) &&
  match e with
  | D _ _ | X _ _ | K _ _ => true
  | Add a b | Sub a b | Mul a b | Min a b => all_fit high a && all_fit high b
  end.

Section Overflow.
Variable at_ : nat -> R.
Hypothesis at_pos : forall t, 0 <= at_ t.
Variable high : nat -> Z.
Hypothesis high_pos : forall t, (0 <= high t)%Z.
Hypothesis below : forall t, at_ t <= bpow radix2 (high t).

Lemma weight_pos i m : (0 <= weight high i m)%Z.
Proof.
  revert i. induction m as [|e m IH]; simpl; intros i; [lia|].
  specialize (IH (S i)). specialize (high_pos i). nia.
Qed.
Lemma weight_spec i m : mev at_ i m <= bpow radix2 (weight high i m).
Proof.
  revert i. induction m as [|e m IH]; simpl; intros i; [lra|]. rewrite bpow_plus.
  apply Rmult_le_compat; auto using pow_le, mev_pos.
  induction e as [|e IHe]; [simpl; lra|].
  replace (Z.of_nat (S e) * high i)%Z with (high i + Z.of_nat e * high i)%Z by lia.
  rewrite bpow_plus. simpl. apply Rmult_le_compat; auto using pow_le.
Qed.
Lemma size_spec p : peval at_ p <= IZR (size high p) * bpow radix2 (-160).
Proof.
  induction p as [|[m c] p IH]; cbn [peval size]; [lra|].
  rewrite plus_IZR, Z.shiftl_mul_pow2, mult_IZR by apply weight_pos.
  change (2 ^ weight high 0 m)%Z with (radix2 ^ weight high 0 m)%Z.
  rewrite IZR_Zpower by apply weight_pos. unfold val.
  pose proof (weight_spec 0 m) as W. pose proof (bpow_ge_0 radix2 (-160)) as B.
  assert (C : 0 <= IZR (Z.of_N c)) by (apply IZR_le; lia).
  pose proof (Rmult_le_compat_l _ _ _ (Rmult_le_pos _ _ C B) W). lra.
Qed.
Lemma fits_spec p : fits high p = true -> peval at_ p < bpow radix2 1024.
Proof.
  unfold fits. intros H. apply Z.ltb_lt in H. apply Rle_lt_trans with (1 := size_spec p).
  rewrite Z.shiftl_1_l in H. apply IZR_lt in H.
  change (2 ^ (1024 + 160))%Z with (radix2 ^ (1024 + 160))%Z in H.
  rewrite IZR_Zpower in H by lia. rewrite bpow_plus in H.
  pose proof (bpow_gt_0 radix2 (-160)) as B. apply Rmult_lt_compat_r with (1 := B) in H.
  rewrite Rmult_assoc, <- (bpow_plus radix2 160) in H. simpl (bpow radix2 (160 + -160)) in H.
  now rewrite Rmult_1_r in H.
Qed.
End Overflow.
