(* ltbw: a filter theorem for every division-free predicate.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   Binary64 with gradual underflow; overflow is excluded by the exactness window, or shows itself
   (an infinite permanent decides nothing). One induction over expressions covers orient2d,
   orient3d, incircle and insphere:
     |fl(e) - exact(e)| <= k(e) * mag(e),
   and comparing |fl(e)| with C * permanent(e), both rounded, is sound if k(e) <= C (1-u) s(e). *)
Require Import Reals QArith Qreals Qminmax Psatz ZArith Lia.
From Flocq Require Import Core Relative.
Open Scope R_scope.

Definition emin := (-1074)%Z.
Definition prec := 53%Z.
Notation fexp := (FLT_exp emin prec).
Notation rnd := (round radix2 fexp ZnearestE).
Global Instance prec_gt_0_ : Prec_gt_0 prec. Proof. now unfold Prec_gt_0, prec. Qed.

Definition u : R := / 2 * bpow radix2 (-53 + 1).
Lemma u_val : u = / IZR (2^53).
Proof. unfold u. change (-53+1)%Z with (-52)%Z. simpl. lra. Qed.

(* multiples of 2^-m *)
Notation mult m := (generic_format radix2 (FIX_exp (- m))).

Lemma mult_weaken m m' x : (m <= m')%Z -> mult m x -> mult m' x.
Proof.
intros H Hx. apply generic_format_FIX. apply FIX_format_generic in Hx. destruct Hx as [[k e] Hx He].
simpl in He. subst e. exists (Float radix2 (k * Zpower radix2 (m' - m)) (-m')).
- rewrite Hx. unfold F2R, Fnum, Fexp. rewrite mult_IZR. rewrite IZR_Zpower by lia.
  rewrite Rmult_assoc, <- bpow_plus. do 2 f_equal. lia.
- reflexivity.
Qed.
Lemma mult_plus m x y : mult m x -> mult m y -> mult m (x + y).
Proof.
intros Hx Hy. apply generic_format_FIX. apply FIX_format_generic in Hx; apply FIX_format_generic in Hy.
destruct Hx as [[k e] Hx He]; destruct Hy as [[k' e'] Hy He']; simpl in *; subst e e'.
exists (Float radix2 (k + k') (-m)); [|reflexivity]. rewrite Hx, Hy. unfold F2R; simpl. rewrite plus_IZR. ring.
Qed.
Lemma mult_opp m x : mult m x -> mult m (-x).
Proof. apply generic_format_opp. Qed.
Lemma mult_mul m m' x y : mult m x -> mult m' y -> mult (m + m') (x * y).
Proof.
intros Hx Hy. apply generic_format_FIX. apply FIX_format_generic in Hx; apply FIX_format_generic in Hy.
destruct Hx as [[k e] Hx He]; destruct Hy as [[k' e'] Hy He']; simpl in *; subst e e'.
exists (Float radix2 (k * k') (-(m+m'))); [|reflexivity]. rewrite Hx, Hy. unfold F2R; simpl. rewrite mult_IZR.
replace (-(m+m'))%Z with (-m + -m')%Z by lia. rewrite bpow_plus. ring.
Qed.
Lemma mult_rnd m x : mult m x -> mult m (rnd x).
Proof. intros Hx. apply generic_round_generic; auto with typeclass_instances. Qed.

(* relative error of rounding, including the subnormal range, for multiples of 2^-1074 *)
Lemma rnd_err x : mult 1074 x -> Rabs (rnd x - x) <= u * Rabs x.
Proof.
intros Hx. destruct (Rle_or_lt (bpow radix2 (emin + prec - 1)) (Rabs x)) as [H|H].
- unfold u. apply (relative_error_N_FLT radix2 emin prec eq_refl). exact H.
- rewrite round_generic; auto with typeclass_instances.
  + rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. apply Rmult_le_pos; [rewrite u_val|apply Rabs_pos].
    apply Rlt_le, Rinv_0_lt_compat. apply IZR_lt. reflexivity.
  + apply generic_format_FLT. apply FIX_format_generic in Hx. destruct Hx as [[k e] Hx He]. simpl in He. subst e.
    exists (Float radix2 k (-1074)); [exact Hx| |simpl; unfold emin; lia].
    simpl. apply lt_IZR. rewrite abs_IZR. rewrite Hx in H. unfold F2R in H. simpl Fnum in H; simpl Fexp in H.
    rewrite Rabs_mult in H. rewrite (Rabs_pos_eq (bpow _ _)) in H by apply bpow_ge_0.
    replace (emin + prec - 1)%Z with (52 + -1074)%Z in H by reflexivity. rewrite bpow_plus in H.
    apply Rmult_lt_reg_r in H; [|apply bpow_gt_0]. apply Rlt_trans with (1:=H). 
    rewrite <- IZR_Zpower by easy. apply IZR_lt. reflexivity.
Qed.

(* the leaves: f = rnd (p - q), x = p - q *)
Lemma leaf_ok z : mult 1074 z -> Rabs (rnd z - z) <= u * Rabs (rnd z).
Proof.
intros Hz. destruct (Rle_or_lt (bpow radix2 (emin + prec - 1)) (Rabs z)) as [H|H].
- assert (H' : bpow radix2 (emin + prec - 1) <= Rabs (rnd z)) by (apply abs_round_ge_generic; auto with typeclass_instances; apply generic_format_bpow; unfold FLT_exp, emin, prec; lia).
  apply Rle_trans with (1 := error_le_half_ulp_round radix2 fexp _ z).
  pose proof (ulp_FLT_le radix2 emin prec _ H'). unfold u. replace (-53+1)%Z with (1 - prec)%Z by reflexivity. lra.
- pose proof (rnd_err z Hz) as E. rewrite round_generic; auto with typeclass_instances.
  + rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. apply Rmult_le_pos; [rewrite u_val|apply Rabs_pos].
    apply Rlt_le, Rinv_0_lt_compat. apply IZR_lt. reflexivity.
  + apply generic_format_FLT. apply FIX_format_generic in Hz. destruct Hz as [[k e] Hx He]. simpl in He. subst e.
    exists (Float radix2 k (-1074)); [exact Hx| |simpl; unfold emin; lia].
    simpl. apply lt_IZR. rewrite abs_IZR. rewrite Hx in H. unfold F2R in H. simpl Fnum in H; simpl Fexp in H.
    rewrite Rabs_mult in H. rewrite (Rabs_pos_eq (bpow _ _)) in H by apply bpow_ge_0.
    replace (emin + prec - 1)%Z with (52 + -1074)%Z in H by reflexivity. rewrite bpow_plus in H.
    apply Rmult_lt_reg_r in H; [|apply bpow_gt_0]. apply Rlt_trans with (1:=H).
    rewrite <- IZR_Zpower by easy. apply IZR_lt. reflexivity.
Qed.

Inductive expr := V (n : nat) | Add (a b : expr) | Sub (a b : expr) | Mul (a b : expr).

Section Filter.
Variable q : Z.                  (* differences are multiples of 2^-q *)
Hypothesis q_pos : (0 <= q)%Z.
Variable f x : nat -> R.         (* rounded and exact coordinate differences *)
Hypothesis f_mult : forall n, mult q (f n).
Hypothesis leaf : forall n, Rabs (f n - x n) <= u * Rabs (f n).

Fixpoint deg e := match e with V _ => 1 | Add a b | Sub a b => Z.max (deg a) (deg b) | Mul a b => deg a + deg b end%Z.
Fixpoint fl e := match e with V n => f n | Add a b => rnd (fl a + fl b) | Sub a b => rnd (fl a - fl b) | Mul a b => rnd (fl a * fl b) end.
Fixpoint ex e := match e with V n => x n | Add a b => ex a + ex b | Sub a b => ex a - ex b | Mul a b => ex a * ex b end.
Fixpoint mag e := match e with V n => Rabs (f n) | Add a b | Sub a b => mag a + mag b | Mul a b => mag a * mag b end.
(* the permanent as computed in floating point *)
Fixpoint pfl e := match e with V n => Rabs (f n) | Add a b | Sub a b => rnd (pfl a + pfl b) | Mul a b => rnd (pfl a * pfl b) end.

Definition uq : Q := 1 # (2^53)%positive.
(* growth g: |fl e| <= g * mag ; error k: |fl e - ex e| <= k * mag ; depth h: mag*(1-u)^h <= pfl *)
Fixpoint g e : Q := match e with V _ => 1 | Add a b | Sub a b => Qmax (g a) (g b) * (1 + uq) | Mul a b => g a * g b * (1 + uq) end%Q.
Fixpoint k e : Q := match e with V _ => uq
  | Add a b | Sub a b => uq * Qmax (g a) (g b) + Qmax (k a) (k b)
  | Mul a b => uq * (g a * g b) + (g a * k b + (g b + k b) * k a) end%Q.
Fixpoint s e : Q := match e with V _ => 1 | Add a b | Sub a b => Qmin (s a) (s b) * (1 - uq) | Mul a b => s a * s b * (1 - uq) end%Q.

Lemma Q2R_uq : Q2R uq = u.
Proof. rewrite u_val. unfold uq, Q2R, Qnum, Qden. change (Z.pos (2 ^ 53)) with (2^53)%Z. now rewrite Rmult_1_l. Qed.
Lemma Q2R_max a b : Q2R (Qmax a b) = Rmax (Q2R a) (Q2R b).
Proof.
destruct (Q.max_spec a b) as [[H E]|[H E]]; rewrite (Qeq_eqR _ _ E).
- rewrite Rmax_right; [reflexivity|]. apply Rlt_le, Qlt_Rlt, H.
- rewrite Rmax_left; [reflexivity|]. apply Qle_Rle, H.
Qed.
Lemma Q2R_min a b : Q2R (Qmin a b) = Rmin (Q2R a) (Q2R b).
Proof.
destruct (Q.min_spec a b) as [[H E]|[H E]]; rewrite (Qeq_eqR _ _ E).
- rewrite Rmin_left; [reflexivity|]. apply Rlt_le, Qlt_Rlt, H.
- rewrite Rmin_right; [reflexivity|]. apply Qle_Rle, H.
Qed.
Lemma Q2R_1 : Q2R 1 = 1. Proof. unfold Q2R; simpl; lra. Qed.

Lemma u_pos : 0 < u. Proof. rewrite u_val. apply Rinv_0_lt_compat. apply IZR_lt. reflexivity. Qed.
Lemma u_lt1 : u < 1.
Proof. rewrite u_val. rewrite <- Rinv_1. apply Rinv_1_lt_contravar; [lra|]. apply IZR_lt. reflexivity. Qed.
Lemma mag_pos e : 0 <= mag e.
Proof. induction e; simpl; try (apply Rabs_pos); try lra. now apply Rmult_le_pos. Qed.
Lemma deg_pos e : (1 <= deg e)%Z. Proof. induction e; simpl; lia. Qed.

Lemma g_ge1 e : 1 <= Q2R (g e).
Proof.
pose proof u_pos. induction e; simpl; rewrite ?Q2R_mult, ?Q2R_max, ?Q2R_plus, ?Q2R_uq, ?Q2R_1; try lra.
- pose proof (Rmax_l (Q2R (g e1)) (Q2R (g e2))). nra.
- pose proof (Rmax_l (Q2R (g e1)) (Q2R (g e2))). nra.
- assert (1 <= Q2R (g e1) * Q2R (g e2)) by nra. nra.
Qed.
Lemma k_pos e : 0 <= Q2R (k e).
Proof.
pose proof u_pos. induction e; simpl; rewrite ?Q2R_plus, ?Q2R_mult, ?Q2R_max, ?Q2R_plus, ?Q2R_uq; try lra.
- pose proof (Rmax_l (Q2R (g e1)) (Q2R (g e2))). pose proof (g_ge1 e1). pose proof (Rmax_l (Q2R (k e1)) (Q2R (k e2))).
  assert (0 <= u * Rmax (Q2R (g e1)) (Q2R (g e2))) by (apply Rmult_le_pos; lra). lra.
- pose proof (Rmax_l (Q2R (g e1)) (Q2R (g e2))). pose proof (g_ge1 e1). pose proof (Rmax_l (Q2R (k e1)) (Q2R (k e2))).
  assert (0 <= u * Rmax (Q2R (g e1)) (Q2R (g e2))) by (apply Rmult_le_pos; lra). lra.
- pose proof (g_ge1 e1). pose proof (g_ge1 e2). 
  assert (0 <= Q2R (g e1) * Q2R (g e2)) by nra.
  assert (0 <= Q2R (g e1) * Q2R (k e2)) by (apply Rmult_le_pos; lra).
  assert (0 <= (Q2R (g e2) + Q2R (k e2)) * Q2R (k e1)) by (apply Rmult_le_pos; lra). nra.
Qed.

Lemma fl_mult e : mult (q * deg e) (fl e).
Proof.
induction e; simpl.
- replace (q*1)%Z with q by lia. apply f_mult.
- apply mult_rnd, mult_plus; [apply mult_weaken with (2:=IHe1)|apply mult_weaken with (2:=IHe2)]; nia.
- apply mult_rnd, mult_plus; [apply mult_weaken with (2:=IHe1)|apply mult_opp, mult_weaken with (2:=IHe2)]; nia.
- rewrite Z.mul_add_distr_l. apply mult_rnd, mult_mul; assumption.
Qed.
Lemma arg_add a b : (q * Z.max (deg a) (deg b) <= 1074)%Z -> mult 1074 (fl a + fl b) /\ mult 1074 (fl a - fl b).
Proof. intros H. split; apply mult_plus; [| |apply mult_weaken with (2:=fl_mult a); nia|apply mult_opp];
 [apply mult_weaken with (2:=fl_mult a); nia|apply mult_weaken with (2:=fl_mult b); nia|apply mult_weaken with (2:=fl_mult b); nia].
Qed.
Lemma arg_mul a b : (q * (deg a + deg b) <= 1074)%Z -> mult 1074 (fl a * fl b).
Proof. intros H. apply mult_weaken with (m := (q * deg a + q * deg b)%Z); [lia|]. apply mult_mul; apply fl_mult. Qed.

Lemma sum_bound ga gb ma mb A B : 0 <= ma -> 0 <= mb -> A <= ga * ma -> B <= gb * mb -> A + B <= Rmax ga gb * (ma + mb).
Proof. intros. pose proof (Rmax_l ga gb). pose proof (Rmax_r ga gb). nra. Qed.

Lemma rnd_abs z : mult 1074 z -> Rabs (rnd z) <= (1 + u) * Rabs z.
Proof. intros Hz. pose proof (rnd_err z Hz). pose proof (Rabs_triang (rnd z - z) z). replace (rnd z - z + z) with (rnd z) in * by ring. lra. Qed.

Lemma growth e : (q * deg e <= 1074)%Z -> Rabs (fl e) <= Q2R (g e) * mag e.
Proof.
pose proof u_pos as Hu.
induction e; intros Hd; simpl; rewrite ?Q2R_mult, ?Q2R_max, ?Q2R_plus, ?Q2R_uq, ?Q2R_1; simpl in Hd.
- lra.
- destruct (arg_add _ _ Hd) as [M _]. apply Rle_trans with (1 := rnd_abs _ M).
  assert (Ha := IHe1 ltac:(nia)). assert (Hb := IHe2 ltac:(nia)).
  pose proof (sum_bound _ _ _ _ _ _ (mag_pos e1) (mag_pos e2) Ha Hb). pose proof (Rabs_triang (fl e1) (fl e2)).
  pose proof (mag_pos e1); pose proof (mag_pos e2). nra.
- destruct (arg_add _ _ Hd) as [_ M]. apply Rle_trans with (1 := rnd_abs _ M).
  assert (Ha := IHe1 ltac:(nia)). assert (Hb := IHe2 ltac:(nia)).
  pose proof (sum_bound _ _ _ _ _ _ (mag_pos e1) (mag_pos e2) Ha Hb). pose proof (Rabs_triang (fl e1) (- fl e2)).
  rewrite Rabs_Ropp in H0. unfold Rminus. pose proof (mag_pos e1); pose proof (mag_pos e2). nra.
- pose proof (arg_mul _ _ Hd) as M. apply Rle_trans with (1 := rnd_abs _ M). rewrite Rabs_mult.
  pose proof (deg_pos e1); pose proof (deg_pos e2).
  assert (Ha := IHe1 ltac:(nia)). assert (Hb := IHe2 ltac:(nia)).
  pose proof (Rmult_le_compat _ _ _ _ (Rabs_pos _) (Rabs_pos _) Ha Hb). nra.
Qed.

Theorem error_bound e : (q * deg e <= 1074)%Z -> Rabs (fl e - ex e) <= Q2R (k e) * mag e.
Proof.
pose proof u_pos as Hu.
induction e; intros Hd; simpl; rewrite ?Q2R_plus, ?Q2R_mult, ?Q2R_max, ?Q2R_plus, ?Q2R_uq; simpl in Hd.
- apply leaf.
- destruct (arg_add _ _ Hd) as [M _]. assert (Ha := IHe1 ltac:(nia)). assert (Hb := IHe2 ltac:(nia)).
  assert (Ga := growth e1 ltac:(nia)). assert (Gb := growth e2 ltac:(nia)).
  pose proof (rnd_err _ M) as E. pose proof (Rabs_triang (fl e1) (fl e2)).
  pose proof (sum_bound _ _ _ _ _ _ (mag_pos e1) (mag_pos e2) Ha Hb).
  pose proof (sum_bound _ _ _ _ _ _ (mag_pos e1) (mag_pos e2) Ga Gb).
  replace (rnd (fl e1 + fl e2) - (ex e1 + ex e2)) with ((rnd (fl e1 + fl e2) - (fl e1 + fl e2)) + ((fl e1 - ex e1) + (fl e2 - ex e2))) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. pose proof (Rabs_triang (fl e1 - ex e1) (fl e2 - ex e2)). nra.
- destruct (arg_add _ _ Hd) as [_ M]. assert (Ha := IHe1 ltac:(nia)). assert (Hb := IHe2 ltac:(nia)).
  assert (Ga := growth e1 ltac:(nia)). assert (Gb := growth e2 ltac:(nia)).
  pose proof (rnd_err _ M) as E. pose proof (Rabs_triang (fl e1) (- fl e2)) as T. rewrite Rabs_Ropp in T. fold (Rminus (fl e1) (fl e2)) in T.
  pose proof (sum_bound _ _ _ _ _ _ (mag_pos e1) (mag_pos e2) Ha Hb).
  pose proof (sum_bound _ _ _ _ _ _ (mag_pos e1) (mag_pos e2) Ga Gb).
  replace (rnd (fl e1 - fl e2) - (ex e1 - ex e2)) with ((rnd (fl e1 - fl e2) - (fl e1 - fl e2)) + ((fl e1 - ex e1) + - (fl e2 - ex e2))) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. pose proof (Rabs_triang (fl e1 - ex e1) (- (fl e2 - ex e2))) as T2. rewrite Rabs_Ropp in T2. nra.
- pose proof (arg_mul _ _ Hd) as M. pose proof (deg_pos e1); pose proof (deg_pos e2).
  assert (Ha := IHe1 ltac:(nia)). assert (Hb := IHe2 ltac:(nia)).
  assert (Ga := growth e1 ltac:(nia)). assert (Gb := growth e2 ltac:(nia)).
  pose proof (rnd_err _ M) as E. rewrite Rabs_mult in E.
  assert (Xb : Rabs (ex e2) <= (Q2R (g e2) + Q2R (k e2)) * mag e2).
  { pose proof (Rabs_triang (fl e2) (-(fl e2 - ex e2))) as T. rewrite Rabs_Ropp in T.
    replace (fl e2 + -(fl e2 - ex e2)) with (ex e2) in T by ring. lra. }
  replace (rnd (fl e1 * fl e2) - ex e1 * ex e2) with ((rnd (fl e1 * fl e2) - fl e1 * fl e2) + (fl e1 * (fl e2 - ex e2) + ex e2 * (fl e1 - ex e1))) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. 
  pose proof (Rabs_triang (fl e1 * (fl e2 - ex e2)) (ex e2 * (fl e1 - ex e1))) as T. rewrite !Rabs_mult in T.
  pose proof (Rmult_le_compat _ _ _ _ (Rabs_pos _) (Rabs_pos _) Ga Gb) as P1.
  pose proof (Rmult_le_compat _ _ _ _ (Rabs_pos _) (Rabs_pos _) Ga Hb) as P2.
  pose proof (Rmult_le_compat _ _ _ _ (Rabs_pos _) (Rabs_pos _) Xb Ha) as P3.
  rewrite ?Q2R_mult in *. nra.
Qed.

(* the permanent computed in floating point *)
Lemma pfl_mult e : mult (q * deg e) (pfl e).
Proof.
induction e; simpl.
- replace (q*1)%Z with q by lia. apply generic_format_abs, f_mult.
- apply mult_rnd, mult_plus; [apply mult_weaken with (2:=IHe1)|apply mult_weaken with (2:=IHe2)]; nia.
- apply mult_rnd, mult_plus; [apply mult_weaken with (2:=IHe1)|apply mult_weaken with (2:=IHe2)]; nia.
- rewrite Z.mul_add_distr_l. apply mult_rnd, mult_mul; assumption.
Qed.
Lemma rnd_low z : mult 1074 z -> 0 <= z -> z * (1 - u) <= rnd z.
Proof. intros Hz P. pose proof (rnd_err z Hz) as E. rewrite (Rabs_pos_eq z P) in E. apply Rabs_le_inv in E. lra. Qed.
Lemma s_range e : 0 < Q2R (s e) <= 1.
Proof.
pose proof u_pos. pose proof u_lt1.
induction e; simpl; rewrite ?Q2R_mult, ?Q2R_min, ?Q2R_minus, ?Q2R_uq, ?Q2R_1; [lra| | |].
- pose proof (Rmin_l (Q2R (s e1)) (Q2R (s e2))). assert (0 < Rmin (Q2R (s e1)) (Q2R (s e2))) by (apply Rmin_pos; tauto). nra.
- pose proof (Rmin_l (Q2R (s e1)) (Q2R (s e2))). assert (0 < Rmin (Q2R (s e1)) (Q2R (s e2))) by (apply Rmin_pos; tauto). nra.
- assert (0 < Q2R (s e1) * Q2R (s e2)) by (apply Rmult_lt_0_compat; tauto).
  assert (Q2R (s e1) * Q2R (s e2) <= 1) by nra. nra.
Qed.
Lemma perm_low e : (q * deg e <= 1074)%Z -> Q2R (s e) * mag e <= pfl e.
Proof.
pose proof u_pos. pose proof u_lt1.
induction e; intros Hd; simpl; rewrite ?Q2R_mult, ?Q2R_min, ?Q2R_minus, ?Q2R_uq, ?Q2R_1; simpl in Hd; [lra| | |].
1,2: assert (Ha := IHe1 ltac:(nia)); assert (Hb := IHe2 ltac:(nia));
  assert (M : mult 1074 (pfl e1 + pfl e2)) by (apply mult_plus; [apply mult_weaken with (2:=pfl_mult e1)|apply mult_weaken with (2:=pfl_mult e2)]; nia);
  pose proof (mag_pos e1); pose proof (mag_pos e2); pose proof (s_range e1); pose proof (s_range e2);
  pose proof (Rmin_l (Q2R (s e1)) (Q2R (s e2))); pose proof (Rmin_r (Q2R (s e1)) (Q2R (s e2)));
  assert (Rmin (Q2R (s e1)) (Q2R (s e2)) * (mag e1 + mag e2) <= pfl e1 + pfl e2) by nra;
  assert (0 < Rmin (Q2R (s e1)) (Q2R (s e2))) by (apply Rmin_pos; tauto);
  assert (0 <= pfl e1 + pfl e2) by nra;
  pose proof (rnd_low _ M H9); nra.
pose proof (deg_pos e1); pose proof (deg_pos e2). assert (Ha := IHe1 ltac:(nia)); assert (Hb := IHe2 ltac:(nia)).
assert (M : mult 1074 (pfl e1 * pfl e2)) by (apply mult_weaken with (m := (q * deg e1 + q * deg e2)%Z); [lia|]; apply mult_mul; apply pfl_mult).
pose proof (mag_pos e1); pose proof (mag_pos e2); pose proof (s_range e1); pose proof (s_range e2).
assert (P : Q2R (s e1) * mag e1 * (Q2R (s e2) * mag e2) <= pfl e1 * pfl e2) by (apply Rmult_le_compat; nra).
assert (0 <= pfl e1 * pfl e2) by (apply Rmult_le_pos; nra).
pose proof (rnd_low _ M H7). nra.
Qed.

(* Main: if |det| > C * pfl (real comparison) and k(e) <= C * s(e), the sign is right *)
Theorem filter_sound e (C : Q) : (q * deg e <= 1074)%Z -> (k e <= C * s e)%Q ->
  (Q2R C * pfl e < fl e -> 0 < ex e) /\ (fl e < - (Q2R C * pfl e) -> ex e < 0).
Proof.
intros Hd HC. apply Qle_Rle in HC. rewrite Q2R_mult in HC.
pose proof (error_bound e Hd) as E. pose proof (perm_low e Hd) as P. pose proof (mag_pos e). pose proof (k_pos e). pose proof (s_range e).
assert (0 <= Q2R C) by nra.
assert (Rabs (fl e - ex e) <= Q2R C * pfl e) by nra.
apply Rabs_le_inv in H3. split; intros; lra.
Qed.

(* overflow self-detection: the float permanent dominates the float determinant node by node *)
Lemma pfl_pos e : 0 <= pfl e.
Proof.
induction e; simpl; [apply Rabs_pos| | |]; rewrite <- (round_0 radix2 fexp ZnearestE); apply round_le; auto with typeclass_instances; try lra; apply Rmult_le_pos; assumption.
Qed.
Lemma fl_le_pfl e : Rabs (fl e) <= pfl e.
Proof.
induction e; simpl; [lra| | |]; rewrite <- (round_NE_abs radix2 fexp) by auto with typeclass_instances; apply round_le; auto with typeclass_instances.
- apply Rle_trans with (1 := Rabs_triang _ _). lra.
- unfold Rminus. apply Rle_trans with (1 := Rabs_triang _ _). rewrite Rabs_Ropp. lra.
- rewrite Rabs_mult. apply Rmult_le_compat; auto using Rabs_pos.
Qed.

(* the test as executed: bound = rnd (Cf * pfl), Cf a binary64 constant that is a multiple of 2^-m *)
Theorem filter_sound_fl e (Cf : Q) m : (0 <= m)%Z -> (q * deg e + m <= 1074)%Z -> mult m (Q2R Cf) -> (0 <= Cf)%Q ->
  (k e <= Cf * (1 - uq) * s e)%Q ->
  (rnd (Q2R Cf * pfl e) < fl e -> 0 < ex e) /\ (fl e < - rnd (Q2R Cf * pfl e) -> ex e < 0).
Proof.
intros Hm Hd HM HC0 HC.
assert (M : mult 1074 (Q2R Cf * pfl e)).
{ apply mult_weaken with (m := (m + q * deg e)%Z); [lia|]. apply mult_mul; [exact HM|apply pfl_mult]. }
assert (P : 0 <= Q2R Cf * pfl e). { apply Rmult_le_pos; [|apply pfl_pos]. replace 0 with (Q2R 0) by (unfold Q2R; simpl; lra). apply Qle_Rle, HC0. }
pose proof (rnd_low _ M P) as L.
destruct (filter_sound e (Cf * (1 - uq))%Q) as [A B]; [lia|exact HC|].
rewrite Q2R_mult, Q2R_minus, Q2R_uq, Q2R_1 in A, B.
split; intros; [apply A|apply B]; nra.
Qed.
End Filter.
