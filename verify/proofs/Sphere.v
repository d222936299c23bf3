(* ltbw: the centre of a cached sphere, in double precision.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   core/src/sphere.rs keeps a sphere only if three conditions on what it has computed hold; they
   bound the distance of the computed centre from the true one. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core.
Require Import Rounding Poly Expr Bound Filter Predicates Means.
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
