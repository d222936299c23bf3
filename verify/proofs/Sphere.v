(* ltbw: cached spheres, from the differences in double precision to the verdict.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   What is left to argue is in the hypotheses of [conditions] and [Cached]: that roundings of
   single operations in double precision cost less than 2^-40. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core.
Require Import Rounding Poly Expr Bound Filter Predicates Means Constants Single Centre.
Import ListNotations.
Open Scope R_scope.

(* Numerators and determinant are those of [exceeds_radius_edge], from the first nine differences:
   one variable, the largest of them. *)
Definition part (e : expr) : filter := {|
  value := e;
  bound := K 0 0;
  leaf_list := leaf_list exceeds_radius_edge;
  extents := [[]; [0; 1; 2; 3; 4; 5; 6; 7; 8]]%nat;
  lows := [];
  highs := []
|}.
(* The largest rounded difference. *)
Definition reach (c : nat -> R) : R := sizes (part (K 0 0)) 0 c 1%nat.

Definition check_part (e : expr) (power : nat) (units : N) : bool :=
  sound e && well_measured (part e) e && Z.leb (fraction 194 e) 1074
  && covered (map (settle (fun _ => 0%Z) [([O; power], N.shiftl units 107)])
                  (snd (bounds e)))
             [([O; power], N.shiftl units 107)].

Theorem part_error e power units c : check_part e power units = true ->
  (forall i, in_window (c i)) ->
  Rabs (fl (computed exceeds_radius_edge c) e - ex (exact exceeds_radius_edge c) e)
    <= IZR (Z.of_N units) * u * reach c ^ power.
Proof.
  unfold check_part. intros C W. do 3 (apply andb_prop in C; destruct C as [C ?]).
  apply Z.leb_le in H0.
  assert (CF : forall i, float (c i)) by (intros i; apply (W i)).
  assert (A : forall t, 0 <= sizes (part e) 0 c t) by (intros; apply sizes_pos; lra).
  assert (M : forall n, mult 194 (computed (part e) c n)) by (intros; now apply computed_window).
  eapply Rle_trans.
  { refine (proj2 (bounded (computed (part e) c) (exact (part e) c) (sizes (part e) 0 c) A
                     (computed_float (part e) c CF) 194 ltac:(lia) (or_intror (conj _ M))
                     e C _ _)).
    - reflexivity.
    - now apply measured.
    - intros _. exact H0. }
  eapply Rle_trans; [apply (settle_all _ A (fun _ => 0%Z)); left; reflexivity|].
  eapply Rle_trans; [apply (covered_spec _ A); exact H|].
  cbn [peval mev]. change (sizes (part e) 0 c 1%nat) with (reach c).
  unfold val. rewrite N.shiftl_mul_pow2, N2Z.inj_mul, mult_IZR, pow2_IZR.
  apply Req_le.
  replace (IZR (Z.of_N units) * bpow radix2 (Z.of_N 107) * bpow radix2 (-160))
    with (IZR (Z.of_N units) * u).
  - simpl. ring.
  - unfold u. rewrite Rmult_assoc, <- bpow_plus. reflexivity.
Qed.

(* 205 u m^4 for each numerator, 47 u m^3 for the determinant. *)
Lemma numerator_x : check_part exceeds_radius_edge_nx 4 205 = true.
Proof. vm_compute. reflexivity. Qed.
Lemma numerator_y : check_part exceeds_radius_edge_ny 4 205 = true.
Proof. vm_compute. reflexivity. Qed.
Lemma numerator_z : check_part exceeds_radius_edge_nz 4 205 = true.
Proof. vm_compute. reflexivity. Qed.
Lemma determinant : check_part exceeds_radius_edge_det 3 47 = true.
Proof. vm_compute. reflexivity. Qed.

(* What the code has checked of a sphere, with the roundings of these few operations as slack:
   l is the computed largest squared length, r the radius, s the scale of the frame. *)
Record conditions (c : nat -> R) (l r s : R) (n' d' : R) : Prop := {
  longest_covers : reach c * reach c <= l * (1 + slack);
  is_not_flat : flatness * (l * r) * (1 - slack) < Rabs d';
  is_not_noise : least_square * l * (1 - slack) <= r * r;
  is_not_large : s * r <= max_radius * (1 + slack);
  radius_pos : 0 <= r;
  scale_pos : 0 <= s;
  quotient_within : Rabs (n' / d') <= r * (1 + slack)
}.

Theorem offset_correct e c l r s : check_part e 4 205 = true ->
  (forall i, in_window (c i)) ->
  let n' := fl (computed exceeds_radius_edge c) e in
  let d' := 2 * fl (computed exceeds_radius_edge c) exceeds_radius_edge_det in
  conditions c l r s n' d' ->
  s * Rabs (n' / d' - ex (exact exceeds_radius_edge c) e
                      / (2 * ex (exact exceeds_radius_edge c) exceeds_radius_edge_det))
    <= 53 / 100 * / 67108864.
Proof.
  intros P W n' d' C. destruct C.
  pose proof (part_error e 4 205 c P W) as E. pose proof (part_error _ 3 47 c determinant W) as D.
  apply (quotient_error _ _ n' d' (reach c) l r s); auto.
  - unfold d'. rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq 2) by lra.
    simpl (IZR (Z.of_N 47)) in D. lra.
  - apply sizes_pos. lra.
Qed.

(* That quotient is the offset of the true centre o from the vertex. *)
Theorem offset_means c o r :
  let a := point c 0 in let b := point c 1 in let d := point c 2 in let p := point c 3 in
  norm2 (minus a o) = r -> norm2 (minus b o) = r -> norm2 (minus d o) = r ->
  norm2 (minus p o) = r ->
  let x := exact exceeds_radius_edge c in
  (ex x exceeds_radius_edge_nx, ex x exceeds_radius_edge_ny, ex x exceeds_radius_edge_nz)
  = scale (2 * ex x exceeds_radius_edge_det) (minus o p).
Proof.
  intros a b d p A B C D x.
  assert (H : forall q, norm2 (minus q o) = r ->
                norm2 (minus q p) = 2 * dot (minus q p) (minus o p)).
  { intros q Q. rewrite <- D in Q. apply Rminus_diag_eq in Q. apply Rminus_diag_uniq.
    rewrite <- Q. destruct q as [[q1 q2] q3], p as [[p1 p2] p3], o as [[o1 o2] o3].
    expand. ring. }
  specialize (H a A) as HA. specialize (H b B) as HB. specialize (H d C) as HC.
  set (u := minus a p) in *. set (v := minus b p) in *. set (w := minus d p) in *.
  set (f := minus o p) in *.
  assert (E : (ex x exceeds_radius_edge_nx, ex x exceeds_radius_edge_ny,
               ex x exceeds_radius_edge_nz)
    = plus (plus (scale (norm2 u) (cross v w)) (scale (norm2 v) (cross w u)))
           (scale (norm2 w) (cross u v))) by reflexivity.
  assert (K : ex x exceeds_radius_edge_det = dot u (cross v w)) by reflexivity.
  rewrite E, K, HA, HB, HC. clear.
  destruct u as [[u1 u2] u3], v as [[v1 v2] v3], w as [[w1 w2] w3], f as [[f1 f2] f3].
  expand. f_equal; [f_equal|]; ring.
Qed.

(* The error of rounding to single precision below a power of two. *)
Lemma rnd32_below x k : (-100 <= k)%Z -> Rabs x <= bpow radix2 k ->
  Rabs (rnd32 x - x) <= bpow radix2 (k - 25).
Proof.
  intros K X. destruct (Req_dec x 0) as [->|N].
  { rewrite round_0 by auto with typeclass_instances. rewrite Rminus_0_r, Rabs_R0.
    apply bpow_ge_0. }
  destruct X as [X|X].
  - apply Rle_trans with (1 := error_le_half_ulp radix2 (FLT_exp (-149) 24) _ x).
    rewrite ulp_neq_0 by exact N. unfold cexp, FLT_exp.
    pose proof (mag_le_bpow radix2 x k N X) as M.
    apply Rle_trans with (/ 2 * bpow radix2 (k - 24)).
    + apply Rmult_le_compat_l; [lra|]. apply bpow_le. lia.
    + replace (k - 24)%Z with (1 + (k - 25))%Z by lia. rewrite bpow_plus.
      change (bpow radix2 1) with 2. lra.
  - rewrite round_generic; auto with typeclass_instances.
    + rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. apply bpow_ge_0.
    + assert (B : generic_format radix2 (FLT_exp (-149) 24) (bpow radix2 k)).
      { apply generic_format_bpow. unfold FLT_exp. lia. }
      destruct (Rcase_abs x) as [L|L].
      * rewrite (Rabs_left _ L) in X. replace x with (- bpow radix2 k) by lra.
        now apply generic_format_opp.
      * rewrite (Rabs_right _ L) in X. now rewrite X.
Qed.

(* One coordinate of a centre: vertex [p] and offset [v] true, [p'] and [w] computed; their sum as
   computed; of a query: true and computed. *)
Record coordinate (p p' v w sum q q' : R) : Prop := {
  vertex_near : Rabs (p' - p) <= slack;
  vertex_inside : Rabs p' <= 1;
  offset_near : Rabs (w - v) <= 53 / 100 * / 67108864 + slack;
  offset_small : Rabs w <= 2 + 4 * slack;
  sum_near : Rabs (sum - (p' + w)) <= slack;
  query_near : Rabs (q' - q) <= slack;
  query_inside : Rabs q' <= 1
}.
Lemma coordinate_near p p' v w sum q q' : coordinate p p' v w sum q q' ->
  Rabs (rnd32 sum - (p + v)) <= 225 / 100 * e /\ Rabs (rnd32 q' - q) <= 51 / 100 * e
  /\ Rabs (rnd32 q' - rnd32 sum) <= 8.
Proof.
  intros [A B C D E F G].
  apply Rabs_le_inv in A, B, C, D, E, F.
  assert (S : Rabs sum <= bpow radix2 2) by (apply Rabs_le; simpl; unfold slack in *; lra).
  pose proof (rnd32_below sum 2 ltac:(lia) S) as R. pose proof (rnd32_below q' 0 ltac:(lia) G) as Q.
  apply Rabs_le_inv in R, Q, G, S. simpl in R, Q, S.
  repeat split; apply Rabs_le; unfold slack, e in *; lra.
Qed.

Section Cached.
(* Vertex, offset and query, true and computed, and the sums p' + w. *)
Variables px py pz px' py' pz' vx vy vz wx wy wz sx sy sz qx qy qz qx' qy' qz' : R.
Hypothesis along_x : coordinate px px' vx wx sx qx qx'.
Hypothesis along_y : coordinate py py' vy wy sy qy qy'.
Hypothesis along_z : coordinate pz pz' vz wz sz qz qz'.
(* The true radius, the length of the computed offset, and the radius as computed. *)
Variables t h r : R.
Hypothesis t_is : length_of t vx vy vz.
Hypothesis h_is : length_of h wx wy wz.
Hypothesis r_near : Rabs (r - h) <= slack.
Hypothesis r_small : 0 <= r <= max_radius.

(* What is stored is near the truth. *)
Theorem stored_near : near (rnd32 sx) (rnd32 sy) (rnd32 sz) (rnd32 r)
  (rnd32 qx') (rnd32 qy') (rnd32 qz') (px + vx) (py + vy) (pz + vz) t qx qy qz.
Proof.
  destruct (coordinate_near _ _ _ _ _ _ _ along_x) as [X1 [X2 X3]].
  destruct (coordinate_near _ _ _ _ _ _ _ along_y) as [Y1 [Y2 Y3]].
  destruct (coordinate_near _ _ _ _ _ _ _ along_z) as [Z1 [Z2 Z3]].
  assert (D0 : 0 <= 53 / 100 * / 67108864 + slack) by (unfold slack; lra).
  assert (A := triangle h t _ _ _ _ _ _ _ h_is t_is D0 (offset_near _ _ _ _ _ _ _ along_x)
    (offset_near _ _ _ _ _ _ _ along_y) (offset_near _ _ _ _ _ _ _ along_z)).
  assert (S : forall a b d, Rabs (a - b) <= d -> Rabs (b - a) <= d)
    by (intros; now rewrite Rabs_minus_sym).
  assert (B := triangle t h _ _ _ _ _ _ _ t_is h_is D0
    (S _ _ _ (offset_near _ _ _ _ _ _ _ along_x)) (S _ _ _ (offset_near _ _ _ _ _ _ _ along_y))
    (S _ _ _ (offset_near _ _ _ _ _ _ _ along_z))).
  assert (R : Rabs r <= bpow radix2 1).
  { apply Rabs_le. unfold max_radius in r_small. simpl. lra. }
  pose proof (rnd32_below r 1 ltac:(lia) R) as Q. apply Rabs_le_inv in Q.
  pose proof r_near as N. apply Rabs_le_inv in N. simpl in Q.
  assert (U : rnd32 r <= max_radius).
  { apply round_le_generic; auto with typeclass_instances; [|lra].
    replace max_radius with (bpow radix2 1) by (unfold max_radius; simpl; lra).
    apply generic_format_bpow. unfold FLT_exp. lia. }
  constructor; auto.
  - apply Rabs_le. unfold slack, e in *. lra.
  - split; [apply rnd32_pos; lra|exact U].
Qed.

(* The verdicts, for the true distance [l] of the query to the centre. *)
Definition squared := distance2 (rnd32 qx' - rnd32 sx) (rnd32 qy' - rnd32 sy) (rnd32 qz' - rnd32
    sz).
Definition far := rnd32 (rnd32 r + tolerance).
Definition nearer := rnd32 (rnd32 r - tolerance).
Theorem cached_sphere_correct l :
  length_of l (qx - (px + vx)) (qy - (py + vy)) (qz - (pz + vz)) ->
  (rnd32 (far * far) < squared -> t < l)
  /\ (squared < rnd32 (nearer * nearer) -> 0 < nearer -> l < t).
Proof.
  intros L. split.
  - intros H. exact (outside_correct _ _ _ _ _ _ _ _ _ _ _ _ _ _ stored_near l H L).
  - intros H P. exact (inside_correct _ _ _ _ _ _ _ _ _ _ _ _ _ _ stored_near l H P L).
Qed.
End Cached.
