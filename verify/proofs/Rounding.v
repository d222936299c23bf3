(* ltbw: rounding to binary64, with gradual underflow.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   [rnd] is rounding to nearest, ties to even, in Flocq's FLT format of 53 bits and least exponent
   -1074: binary64 without an upper end. Filter.v proves that nothing reaches that end. *)
Require Import Reals Psatz ZArith Lia.
From Flocq Require Import Core Relative.
Open Scope R_scope.

Definition emin := (-1074)%Z.
Definition prec := 53%Z.
Notation fexp := (FLT_exp emin prec).
Notation rnd := (round radix2 fexp ZnearestE).
Notation float := (generic_format radix2 fexp).
Global Instance prec_gt_0_ : Prec_gt_0 prec. Proof. now unfold Prec_gt_0, prec. Qed.

(* The unit roundoff, 2^-53. *)
Definition u : R := bpow radix2 (-53).
Lemma u_pos : 0 < u. Proof. apply bpow_gt_0. Qed.
Lemma u_small : u <= / 1024.
Proof.
  unfold u. apply Rle_trans with (bpow radix2 (-10)); [apply bpow_le; lia|].
  simpl. lra.
Qed.

Lemma half_u : / 2 * bpow radix2 (- prec + 1) = u.
Proof. unfold u. change (- prec + 1)%Z with (-52)%Z. simpl. lra. Qed.

(* Multiples of 2^-m. *)
Notation mult m := (generic_format radix2 (FIX_exp (- m))).

Lemma mult_spec m x : mult m x <-> exists k, x = IZR k * bpow radix2 (- m).
Proof.
  split.
  - intros H. apply FIX_format_generic in H. destruct H as [[k e] Hx He].
    simpl in He. subst e. exists k. exact Hx.
  - intros [k H]. apply generic_format_FIX. exists (Float radix2 k (- m)); [exact H|reflexivity].
Qed.

Lemma mult_weaken m m' x : (m <= m')%Z -> mult m x -> mult m' x.
Proof.
  rewrite !mult_spec. intros H [k ->]. exists (k * Zpower radix2 (m' - m))%Z.
  rewrite mult_IZR, IZR_Zpower by lia. rewrite Rmult_assoc, <- bpow_plus.
  do 2 f_equal. lia.
Qed.

Lemma mult_plus m x y : mult m x -> mult m y -> mult m (x + y).
Proof.
  rewrite !mult_spec. intros [k ->] [l ->]. exists (k + l)%Z. rewrite plus_IZR. ring.
Qed.

Lemma mult_opp m x : mult m x -> mult m (- x).
Proof. apply generic_format_opp. Qed.

Lemma mult_minus m x y : mult m x -> mult m y -> mult m (x - y).
Proof. intros. apply mult_plus; [assumption|now apply mult_opp]. Qed.

Lemma mult_mul m m' x y : mult m x -> mult m' y -> mult (m + m') (x * y).
Proof.
  rewrite !mult_spec. intros [k ->] [l ->]. exists (k * l)%Z. rewrite mult_IZR.
  replace (- (m + m'))%Z with (- m + - m')%Z by lia. rewrite bpow_plus. ring.
Qed.

Lemma mult_rnd m x : mult m x -> mult m (rnd x).
Proof. intros Hx. apply generic_round_generic; auto with typeclass_instances. Qed.

Lemma mult_0 m : mult m 0.
Proof. apply generic_format_0. Qed.

Lemma mult_bpow m e : (- m <= e)%Z -> mult m (bpow radix2 e).
Proof.
  intros H. apply mult_spec. exists (Zpower radix2 (e + m)).
  rewrite IZR_Zpower by lia. rewrite <- bpow_plus. f_equal. lia.
Qed.

Lemma float_mult x : float x -> mult 1074 x.
Proof. apply generic_format_FIX_FLT. Qed.

Lemma float_rnd x : float (rnd x).
Proof. apply generic_format_round; auto with typeclass_instances. Qed.

Lemma float_bpow e : (-1074 <= e)%Z -> float (bpow radix2 e).
Proof. intros H. apply generic_format_bpow. unfold FLT_exp, emin, prec. lia. Qed.

(* A multiple of 2^-1074 below 2^53 of them is a float. *)
Lemma float_small k e : (-1074 <= e)%Z -> (Z.abs k <= 2^53)%Z -> float (IZR k * bpow radix2 e).
Proof.
  intros He Hk. destruct (Z.eq_dec (Z.abs k) (2^53)) as [E|E].
  - assert (H : IZR k * bpow radix2 e = bpow radix2 (53 + e)
             \/ IZR k * bpow radix2 e = - bpow radix2 (53 + e)).
    { rewrite bpow_plus. replace (bpow radix2 53) with (IZR (2^53)) by reflexivity.
      destruct (Z.abs_eq_or_opp k) as [A|A]; rewrite A in E; [left|right].
      - now rewrite E.
      - replace k with (- 2^53)%Z by lia. rewrite opp_IZR. ring. }
    destruct H as [-> | ->]; [|apply generic_format_opp]; apply float_bpow; lia.
  - apply generic_format_FLT. exists (Float radix2 k e); [reflexivity| |exact He].
    simpl. change (Z.pow_pos 2 53) with (2^53)%Z. lia.
Qed.

(* The relative error, in the range of subnormals as well, for multiples of 2^-1074. *)
Lemma rnd_err x : mult 1074 x -> Rabs (rnd x - x) <= u * Rabs x.
Proof.
  intros Hx. destruct (Rle_or_lt (bpow radix2 (emin + prec - 1)) (Rabs x)) as [H|H].
  - assert (E := relative_error_N_FLT radix2 emin prec eq_refl (fun z => negb (Z.even z)) x H).
    now rewrite half_u in E.
  - rewrite round_generic; auto with typeclass_instances.
    + rewrite Rminus_diag_eq, Rabs_R0 by reflexivity.
      apply Rmult_le_pos; [apply Rlt_le, u_pos|apply Rabs_pos].
    + apply mult_spec in Hx. destruct Hx as [k ->]. apply float_small; [lia|].
      apply le_IZR. rewrite abs_IZR. rewrite Rabs_mult in H.
      rewrite (Rabs_pos_eq (bpow _ _)) in H by apply bpow_ge_0.
      replace (emin + prec - 1)%Z with (52 + -1074)%Z in H by reflexivity.
      rewrite bpow_plus in H. apply Rmult_lt_reg_r in H; [|apply bpow_gt_0].
      apply Rlt_le, Rlt_trans with (1 := H).
      rewrite <- IZR_Zpower by easy. apply IZR_lt. reflexivity.
Qed.

(* The error of any rounding: gradual underflow adds less than the least positive number. *)
Lemma rnd_err_any x : Rabs (rnd x - x) <= u * Rabs x + bpow radix2 (-1074).
Proof.
  destruct (error_N_FLT radix2 emin prec eq_refl (fun z => negb (Z.even z)) x)
    as (eps & eta & He & Hn & _ & ->).
  replace (x * (1 + eps) + eta - x) with (x * eps + eta) by ring.
  apply Rle_trans with (1 := Rabs_triang _ _). rewrite Rabs_mult.
  assert (E : Rabs eps <= u).
  { rewrite <- half_u. exact He. }
  assert (N : Rabs eta <= bpow radix2 (-1074)).
  { apply Rle_trans with (1 := Hn). unfold emin. pose proof (bpow_ge_0 radix2 (-1074)). lra. }
  pose proof (Rabs_pos x). nra.
Qed.

(* The error of a difference of floats, relative to the rounded one. *)
Lemma difference_err z : mult 1074 z -> Rabs (rnd z - z) <= u * Rabs (rnd z).
Proof.
  intros Hz. destruct (Rle_or_lt (bpow radix2 (emin + prec - 1)) (Rabs z)) as [H|H].
  - assert (H' : bpow radix2 (emin + prec - 1) <= Rabs (rnd z)).
    { apply abs_round_ge_generic; auto with typeclass_instances. apply float_bpow.
      unfold emin, prec. lia. }
    apply Rle_trans with (1 := error_le_half_ulp_round radix2 fexp _ z).
    pose proof (ulp_FLT_le radix2 emin prec _ H') as U. unfold u.
    replace (-53)%Z with (1 - prec + -1)%Z by reflexivity. rewrite bpow_plus.
    replace (bpow radix2 (-1)) with (/ 2) by reflexivity. pose proof (Rabs_pos (rnd z)). lra.
  - rewrite round_generic; auto with typeclass_instances.
    + rewrite Rminus_diag_eq, Rabs_R0 by reflexivity.
      apply Rmult_le_pos; [apply Rlt_le, u_pos|apply Rabs_pos].
    + apply mult_spec in Hz. destruct Hz as [k ->]. apply float_small; [lia|].
      apply le_IZR. rewrite abs_IZR. rewrite Rabs_mult in H.
      rewrite (Rabs_pos_eq (bpow _ _)) in H by apply bpow_ge_0.
      replace (emin + prec - 1)%Z with (52 + -1074)%Z in H by reflexivity.
      rewrite bpow_plus in H. apply Rmult_lt_reg_r in H; [|apply bpow_gt_0].
      apply Rlt_le, Rlt_trans with (1 := H).
      rewrite <- IZR_Zpower by easy. apply IZR_lt. reflexivity.
Qed.

(* A difference of floats is rounded to zero only if it is zero. *)
Lemma difference_0 p q : float p -> float q -> rnd (p - q) = 0 -> p = q.
Proof.
  intros Hp Hq H. apply float_mult in Hp. apply float_mult in Hq.
  pose proof (difference_err (p - q) (mult_minus _ _ _ Hp Hq)) as E.
  rewrite H, Rabs_R0, Rmult_0_r, Rminus_0_l, Rabs_Ropp in E.
  pose proof (Rabs_pos (p - q)).
  assert (Rabs (p - q) = 0) as Z by lra.
  destruct (Req_dec (p - q) 0) as [|N]; [lra|]. now apply Rabs_no_R0 in N.
Qed.

Lemma rnd_pos x : 0 <= x -> 0 <= rnd x.
Proof.
  intros H. rewrite <- (round_0 radix2 fexp ZnearestE).
  apply round_le; auto with typeclass_instances.
Qed.
