(* ltbw: filters, and when their decisions are right.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   A filter computes a value and a bound of its error; if the value is beyond the bound, its sign is
   that of the exact value. [check_guard] and [check_window] are programs; the theorems say that
   what they accept is right, so that each constant is proved by running them. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core.
Require Import Rounding Poly Expr Bound.
Import ListNotations.
Open Scope R_scope.

(* A leaf is the rounded difference of two numbers of the input, or one of them. *)
Inductive leaf := Diff (p q : nat) | Param (p : nat).

Record filter := Filter {
  value : expr;
  (* An expression of variables: [X t t] is the largest |leaf| of extent t. *)
  bound : expr;
  leaf_list : list leaf;
  (* The leaves whose largest absolute value is variable 1, 2, ...; the first entry is not used. *)
  extents : list (list nat);
  (* The filter for any coordinates answers if variable t is in (2^low, 2^high). *)
  lows : list Z;
  highs : list Z
}.

(* The exactness window: 0 or 2^-142 <= |c| < 2^200. *)
Definition in_window (c : R) :=
  float c /\ (c = 0 \/ bpow radix2 (-142) <= Rabs c) /\ Rabs c < bpow radix2 200.

Lemma window_mult c : in_window c -> mult 194 c.
Proof.
  intros [F [[-> | L] _]]; [apply mult_0|].
  unfold generic_format in F. rewrite F. clear F.
  assert (C : c <> 0).
  { intros ->. rewrite Rabs_R0 in L. pose proof (bpow_gt_0 radix2 (-142)). lra. }
  apply mult_weaken with (- cexp radix2 fexp c)%Z.
  - unfold cexp, FLT_exp, emin, prec.
    assert (M : (-142 < mag radix2 c)%Z).
    { apply lt_bpow with radix2. apply Rle_lt_trans with (1 := L). now apply bpow_mag_gt. }
    lia.
  - apply mult_spec. eexists. unfold F2R. simpl. rewrite Z.opp_involutive. reflexivity.
Qed.

Definition largest (f : nat -> R) (l : list nat) : R :=
  fold_right (fun n r => Rmax (Rabs (f n)) r) 0 l.

Lemma largest_pos f l : 0 <= largest f l.
Proof.
  induction l as [|n l IH]; simpl; [lra|]. apply Rle_trans with (1 := IH), Rmax_r.
Qed.
Lemma largest_in f l n : In n l -> Rabs (f n) <= largest f l.
Proof.
  induction l as [|m l IH]; simpl; [easy|]. intros [-> | H]; [apply Rmax_l|].
  apply Rle_trans with (1 := IH H), Rmax_r.
Qed.
Lemma largest_is (Q : R -> Prop) f l : Q 0 -> (forall n, Q (Rabs (f n))) -> Q (largest f l).
Proof.
  intros Z H. induction l as [|n l IH]; simpl; [exact Z|].
  unfold Rmax. destruct (Rle_dec _ _); auto.
Qed.
Lemma largest_le f l r : 0 <= r -> (forall n, Rabs (f n) <= r) -> largest f l <= r.
Proof. intros. induction l; simpl; [lra|]. now apply Rmax_lub. Qed.

Section Filters.
Variable F : filter.

(* Computed and exact leaves for the input [c]. *)
Definition computed (c : nat -> R) (n : nat) : R :=
  match nth_error (leaf_list F) n with
  | Some (Diff p q) => rnd (c p - c q)
  | Some (Param p) => c p
  | None => 0
  end.
Definition exact (c : nat -> R) (n : nat) : R :=
  match nth_error (leaf_list F) n with
  | Some (Diff p q) => c p - c q
  | Some (Param p) => c p
  | None => 0
  end.
(* The variables; number 0 is the cost of an underflow. *)
Definition sizes (eta : R) (c : nat -> R) (t : nat) : R :=
  match t with O => eta | S _ => largest (computed c) (nth t (extents F) []) end.

(* Value and bound in floating point; the exact value. *)
Definition fl_value c := fl (computed c) (value F).
Definition fl_bound c := fl (sizes 0 c) (bound F).
Definition exact_value c := ex (exact c) (value F).

(* Every leaf belongs to the extent that bounds it. *)
Definition member (n t : nat) : bool :=
  negb (Nat.eqb t 0) && existsb (Nat.eqb n) (nth t (extents F) []).
Fixpoint well_measured (e : expr) : bool :=
  match e with
  | D n t => member n t
  | X n t =>
      member n t && match nth_error (leaf_list F) n with Some (Param _) => true | _ => false end
  | K _ _ => true
  | Add a b | Sub a b | Mul a b | Min a b => well_measured a && well_measured b
  end.
(* The bound uses the variables 1, 2, ... that there are. *)
Fixpoint in_range (e : expr) : bool :=
  match e with
  | D _ _ => false
  | X n t => Nat.eqb n t && negb (Nat.eqb t 0) && Nat.ltb t (length (extents F))
  | K _ _ => true
  | Add a b | Sub a b | Mul a b | Min a b => in_range a && in_range b
  end.

Definition high_window (t : nat) : Z := match t with O => 0 | _ => 201 end.
Definition low_guard (t : nat) : Z := nth t (lows F) 0%Z.
Definition high_guard (t : nat) : Z := match t with O => 0 | _ => nth t (highs F) 0%Z end.

(* The bound covers the error; [low] is where the variables begin. *)
Definition covers (low : nat -> Z) : bool :=
  let l := lower (bound F) in
  covered (map (settle low l) (snd (bounds (value F)))) l.
Definition shape : bool :=
  sound (value F) && sound (bound F) && is_bound (bound F) && well_measured (value F)
  && in_range (bound F)
  && forallb (fun x => Nat.leb (length (fst x)) (length (extents F))) (lower (bound F)).

Definition check_window : bool :=
  shape && Z.leb (fraction 194 (value F)) 1074 && Z.leb (fraction 194 (bound F)) 1074
  && covers (fun _ => (-194)%Z)
  && all_fit high_window (value F) && all_fit high_window (bound F).
Definition check_guard : bool :=
  shape && covers low_guard && normal low_guard (bound F)
  && forallb (Z.leb 0) (highs F)
  && all_fit high_guard (value F) && all_fit high_guard (bound F).

Section Facts.
Variable c : nat -> R.
Hypothesis c_float : forall i, float (c i).

Lemma computed_float n : float (computed c n).
Proof.
  unfold computed. destruct (nth_error _ n) as [[p q|p]|]; auto using float_rnd.
  apply generic_format_0.
Qed.
Lemma computed_err n : Rabs (computed c n - exact c n) <= u * Rabs (computed c n).
Proof.
  pose proof u_pos. unfold computed, exact. destruct (nth_error _ n) as [[p q|p]|].
  - apply difference_err, mult_minus; now apply float_mult.
  - rewrite Rminus_diag_eq, Rabs_R0 by reflexivity.
    apply Rmult_le_pos; [lra|apply Rabs_pos].
  - rewrite Rminus_0_r, Rabs_R0. lra.
Qed.
Lemma computed_window n : (forall i, in_window (c i)) -> mult 194 (computed c n).
Proof.
  intros W. unfold computed. destruct (nth_error _ n) as [[p q|p]|].
  - apply mult_rnd, mult_minus; now apply window_mult.
  - now apply window_mult.
  - apply mult_0.
Qed.

Lemma member_spec eta n t : member n t = true -> Rabs (computed c n) <= sizes eta c t.
Proof.
  unfold member. intros H. apply andb_prop in H. destruct H as [T H].
  destruct t; [discriminate|]. apply existsb_exists in H. destruct H as [m [I E]].
  apply Nat.eqb_eq in E. subst. now apply largest_in.
Qed.
Lemma measured eta e : well_measured e = true ->
  leaves (computed c) (exact c) (sizes eta c) e.
Proof.
  pose proof u_pos. induction e; cbn [well_measured leaves]; intros W; auto.
  - pose proof (member_spec eta _ _ W) as M. split; [exact M|].
    apply Rle_trans with (1 := computed_err n). apply Rmult_le_compat_l; lra.
  - apply andb_prop in W. destruct W as [W E]. split; [now apply member_spec|].
    unfold computed, exact. destruct (nth_error _ n) as [[p q|p]|]; easy.
  - apply andb_prop in W. destruct W. auto.
  - apply andb_prop in W. destruct W. auto.
  - apply andb_prop in W. destruct W. auto.
  - apply andb_prop in W. destruct W. auto.
Qed.

Lemma sizes_pos eta t : 0 <= eta -> 0 <= sizes eta c t.
Proof. intros. destruct t; [assumption|apply largest_pos]. Qed.
Lemma sizes_float eta t : float eta -> float (sizes eta c t).
Proof.
  intros. destruct t; [assumption|]. cbn [sizes]. apply (largest_is (fun r => float r)); [apply
      generic_format_0|].
  intros. apply generic_format_abs, computed_float.
Qed.
(* The bound does not contain variable 0. *)
Lemma bound_sizes eta e : in_range e = true -> fl (sizes eta c) e = fl (sizes 0 c) e.
Proof.
  induction e; cbn [in_range fl]; intros H; try discriminate; auto.
  - apply andb_prop in H. destruct H as [H _]. apply andb_prop in H. destruct H as [H N].
    apply Nat.eqb_eq in H. subst. now destruct t.
  - apply andb_prop in H. destruct H. now rewrite IHe1, IHe2.
  - apply andb_prop in H. destruct H. now rewrite IHe1, IHe2.
  - apply andb_prop in H. destruct H. now rewrite IHe1, IHe2.
  - apply andb_prop in H. destruct H. now rewrite IHe1, IHe2.
Qed.

Lemma bound_leaves eta e : in_range e = true ->
  leaves (sizes 0 c) (sizes 0 c) (sizes eta c) e.
Proof.
  induction e; cbn [in_range leaves]; intros H; try discriminate; auto;
    try (apply andb_prop in H; destruct H; auto; fail).
  apply andb_prop in H. destruct H as [H _]. apply andb_prop in H. destruct H as [H N].
  apply Nat.eqb_eq in H. subst. destruct t; [discriminate|]. split; [|reflexivity].
  exact (Req_le _ _ (Rabs_pos_eq _ (sizes_pos 0 (S t) (Rle_refl 0)))).
Qed.

(* What both theorems come down to. *)
Lemma sound_by eta low q : (eta = 0 \/ eta = bpow radix2 (-1074)) ->
  (eta = 0 -> (0 <= q)%Z /\ (forall n, mult q (computed c n))
              /\ (fraction q (value F) <= 1074)%Z) ->
  (eta <> 0 -> targets_above (sizes eta c) low (lower (bound F))) ->
  precise (sizes eta c) (bound F) -> shape = true -> covers low = true ->
  Rabs (fl_value c - exact_value c) <= fl_bound c.
Proof.
  intros R W G P S C. unfold shape in S. do 5 (apply andb_prop in S; destruct S as [S ?]).
  assert (E0 : 0 <= eta) by (destruct R as [-> | ->]; [lra|apply bpow_ge_0]).
  assert (EF : float eta).
  { destruct R as [-> | ->]; [apply generic_format_0|apply float_bpow; lia]. }
  pose proof (fun t => sizes_pos eta t E0) as A.
  unfold fl_bound. rewrite <- (bound_sizes eta) by assumption.
  eapply Rle_trans; [|apply (lower_bound (sizes eta c) A); auto; intros; now apply sizes_float].
  destruct (Req_dec eta 0) as [Z|Z].
  - destruct (W Z) as [Q [M N]].
    eapply Rle_trans.
    { refine (proj2 (bounded (computed c) (exact c) (sizes eta c) A computed_float q Q
                       (or_intror (conj Z M)) (value F) _ _ _)); auto.
      - now apply measured.
      - intros _. exact N. }
    eapply Rle_trans; [|apply (covered_spec _ A); exact C].
    apply settle_all; [exact A|]. left. exact Z.
  - destruct R as [R|R]; [easy|].
    eapply Rle_trans.
    { refine (proj2 (bounded (computed c) (exact c) (sizes eta c) A computed_float 0
                       (Z.le_refl 0) (or_introl R) (value F) _ _ _)); auto.
      - now apply measured.
      - intros H'. cbn [sizes] in H'. easy. }
    eapply Rle_trans; [|apply (covered_spec _ A); exact C].
    apply settle_all; [exact A|]. right. split; [exact R|]. auto.
Qed.

(* Every computed value is below 2^1024. *)
Fixpoint parts (e : expr) : list expr :=
  e :: match e with
       | D _ _ | X _ _ | K _ _ => []
       | Add a b | Sub a b | Mul a b | Min a b => parts a ++ parts b
       end.
Lemma fits_by eta high q f x e : (eta = 0 \/ eta = bpow radix2 (-1074)) ->
  (eta = 0 -> (0 <= q)%Z /\ (forall n, mult q (f n)) /\ (fraction q e <= 1074)%Z) ->
  (forall n, float (f n)) ->
  (forall t, (0 <= high t)%Z) -> (forall t, sizes eta c t <= bpow radix2 (high t)) ->
  leaves f x (sizes eta c) e -> sound e = true -> all_fit high e = true ->
  Forall (fun p => Rabs (fl f p) < bpow radix2 1024) (parts e).
Proof.
  intros R W FF H B L S V.
  assert (E0 : 0 <= eta) by (destruct R as [-> | ->]; [lra|apply bpow_ge_0]).
  pose proof (fun t => sizes_pos eta t E0) as A.
  assert (G : forall e, leaves f x (sizes eta c) e -> sound e = true ->
    (eta = 0 -> (fraction q e <= 1074)%Z) -> fits high (fst (bounds e)) = true ->
    Rabs (fl f e) < bpow radix2 1024).
  { intros e' L' S' W' V'. eapply Rle_lt_trans; [|exact (fits_spec _ A high H B _ V')].
    destruct (Req_dec eta 0) as [Z|Z].
    - destruct (W Z) as [Q [M _]].
      refine (proj1 (bounded f x _ A FF q Q (or_intror (conj Z M)) e' S' L' _)).
      intros _. now apply W'.
    - destruct R as [R|R]; [easy|].
      refine (proj1 (bounded f x _ A FF 0 (Z.le_refl 0) (or_introl R) e' S' L' _)).
      intros H'. cbn [sizes] in H'. easy. }
  assert (W2 : eta = 0 -> (0 <= q)%Z /\ (fraction q e <= 1074)%Z) by (intros Z; destruct (W Z);
      tauto).
  clear W.
  induction e; cbn [all_fit parts] in *; apply andb_prop in V; destruct V as [V1 V2];
    (constructor; [apply G; auto; intros Z; apply (W2 Z)|]); try constructor;
    cbn [sound leaves] in *; apply andb_prop in S; destruct S; destruct L;
    apply andb_prop in V2; destruct V2; apply Forall_app; split;
    (apply IHe1 || apply IHe2); auto; intros Z; destruct (W2 Z) as [Q N]; split; auto;
    cbn [fraction] in N; pose proof (fraction_pos q Q e1); pose proof (fraction_pos q Q e2); lia.
Qed.
End Facts.

Definition finite f e := Forall (fun p => Rabs (fl f p) < bpow radix2 1024) (parts e).

(* In the exactness window, without a guard. *)
Theorem window_sound c : check_window = true -> (forall i, in_window (c i)) ->
  Rabs (fl_value c - exact_value c) <= fl_bound c
  /\ finite (computed c) (value F) /\ finite (sizes 0 c) (bound F).
Proof.
  unfold check_window. intros C W. do 5 (apply andb_prop in C; destruct C as [C ?]).
  apply Z.leb_le in H2, H3.
  assert (CF : forall i, float (c i)) by (intros i; apply (W i)).
  assert (M : forall n, mult 194 (computed c n)) by (intros; now apply computed_window).
  assert (MS : forall t, mult 194 (sizes 0 c t)).
  { intros [|t]; [apply mult_0|]. apply (largest_is (fun r => mult 194 r)); [apply mult_0|].
    intros. now apply generic_format_abs. }
  assert (B : forall t, sizes 0 c t <= bpow radix2 (high_window t)).
  { intros [|t]; cbn [sizes high_window]; [simpl; lra|]. apply largest_le; [apply bpow_ge_0|].
    intros n. unfold computed. destruct (nth_error _ n) as [[p q|p]|].
    - apply abs_round_le_generic; auto with typeclass_instances; [apply float_bpow; lia|].
      destruct (W p) as [_ [_ Wp]]. destruct (W q) as [_ [_ Wq]].
      unfold Rminus. apply Rle_trans with (1 := Rabs_triang _ _). rewrite Rabs_Ropp.
      change 201%Z with (1 + 200)%Z. rewrite bpow_plus. change (bpow radix2 1) with 2. lra.
    - destruct (W p) as [_ [_ Wp]]. pose proof (bpow_le radix2 200 201 ltac:(lia)). lra.
    - rewrite Rabs_R0. apply bpow_ge_0. }
  pose proof C as S. unfold shape in S. do 5 (apply andb_prop in S; destruct S as [S ?]).
  split; [|split].
  - apply sound_by with (eta := 0) (q := 194%Z) (low := fun _ => (-194)%Z); auto.
    + intros _. repeat split; auto; lia.
    + easy.
    + apply precise_window with 194%Z; auto. lia.
  - apply (fits_by c 0 high_window 194 (computed c) (exact c)); auto using computed_float.
    + intros _. repeat split; auto; lia.
    + intros [|t]; simpl; lia.
    + now apply measured.
  - apply (fits_by c 0 high_window 194 (sizes 0 c) (sizes 0 c)); auto.
    + intros _. repeat split; auto; lia.
    + intros. apply sizes_float; [assumption|apply generic_format_0].
    + intros [|t]; simpl; lia.
    + now apply bound_leaves.
Qed.

(* For any coordinates, under the guard. *)
Theorem guard_sound c : check_guard = true -> (forall i, float (c i)) ->
  (forall t, (0 < t < length (extents F))%nat ->
     bpow radix2 (low_guard t) <= sizes 0 c t <= bpow radix2 (high_guard t)) ->
  Rabs (fl_value c - exact_value c) <= fl_bound c
  /\ finite (computed c) (value F) /\ finite (sizes 0 c) (bound F).
Proof.
  unfold check_guard. intros C CF G. do 5 (apply andb_prop in C; destruct C as [C ?]).
  set (eta := bpow radix2 (-1074)).
  assert (E0 : 0 <= eta) by apply bpow_ge_0.
  assert (N0 : eta <> 0) by (pose proof (bpow_gt_0 radix2 (-1074)); unfold eta; lra).
  assert (SE : forall t, (0 < t)%nat -> sizes eta c t = sizes 0 c t) by (now intros [|t]).
  assert (HP : forall t, (0 <= high_guard t)%Z).
  { intros [|t]; [simpl; lia|]. unfold high_guard.
    destruct (nth_in_or_default (S t) (highs F) 0%Z) as [I| ->]; [|lia].
    apply Z.leb_le. apply (proj1 (forallb_forall _ _) H1 _ I). }
  assert (B : forall eta', eta' <= 1 -> forall t, sizes eta' c t <= bpow radix2 (high_guard t)).
  { intros eta' L [|t]; [simpl; lra|].
    destruct (Nat.lt_ge_cases (S t) (length (extents F))) as [I|I].
    - change (sizes eta' c (S t)) with (sizes 0 c (S t)). apply G. lia.
    - cbn [sizes]. rewrite nth_overflow by exact I. apply bpow_ge_0. }
  assert (L1 : eta <= 1) by (apply (bpow_le radix2 _ 0); lia).
  pose proof C as S. unfold shape in S. do 5 (apply andb_prop in S; destruct S as [S ?]).
  assert (AB : forall e, in_range e = true -> above (sizes eta c) low_guard e).
  { induction e; cbn [in_range above]; intros I; try discriminate; auto;
      try (apply andb_prop in I; destruct I; auto; fail).
    apply andb_prop in I. destruct I as [I I3]. apply andb_prop in I. destruct I as [I1 I2].
    apply Nat.ltb_lt in I3. destruct t; [discriminate|]. rewrite SE by lia. apply G. lia. }
  split; [|split].
  - apply sound_by with (eta := eta) (q := 0%Z) (low := low_guard); auto.
    + easy.
    + intros _. apply Forall_forall. intros [m k] I. cbn [fst].
      pose proof (proj1 (forallb_forall _ _) H4 _ I) as L. cbn [fst] in L.
      apply Nat.leb_le in L. destruct m as [|[|e] m]; auto. cbn [length] in L. clear I.
      assert (forall i m, (0 < i)%nat -> (i + length m <= length (extents F))%nat ->
                all_above (sizes eta c) low_guard i m) as A.
      { intros i m0. revert i. induction m0 as [|e m0 IH]; intros i I1 I2; [exact Logic.I|].
        cbn [length] in I2. split; [left; rewrite SE by lia; apply G; lia|apply IH; lia]. }
      apply A; lia.
    + apply precise_guard with low_guard; auto.
      intros. now apply sizes_pos.
  - apply (fits_by c eta high_guard 0 (computed c) (exact c)); auto using computed_float.
    + easy.
    + now apply measured.
  - apply (fits_by c eta high_guard 0 (sizes 0 c) (sizes 0 c)); auto.
    + easy.
    + intros. apply sizes_float; [assumption|apply generic_format_0].
    + now apply bound_leaves.
Qed.
End Filters.
