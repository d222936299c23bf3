(* ltbw: the test of a cached sphere, in single precision.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   If the stored centre, radius and query are close enough to the true ones, what
   core/kernel/src/sphere.rs says of a query is true. *)
Require Import Reals Psatz ZArith Lia.
From Flocq Require Import Core Relative.
Require Import Constants.
Open Scope R_scope.

Notation rnd32 := (round radix2 (FLT_exp (-149) 24) ZnearestE).
Global Instance prec32_gt_0 : Prec_gt_0 24. Proof. now unfold Prec_gt_0. Qed.

(* Half an ulp of 1, and the least positive number. *)
Definition e : R := / 16777216.
Definition least32 : R := bpow radix2 (-149).
Lemma least32_pos : 0 < least32. Proof. apply bpow_gt_0. Qed.
Lemma least32_small : least32 <= / 1000000000000000000000000000000000000000.
Proof.
  apply Rle_trans with (bpow radix2 (-130)); [apply bpow_le; lia|]. simpl. lra.
Qed.

Lemma rnd32_err x : Rabs (rnd32 x - x) <= e * Rabs x + least32.
Proof.
  destruct (error_N_FLT radix2 (-149) 24 eq_refl (fun z => negb (Z.even z)) x)
    as (eps & eta & He & Hn & _ & ->).
  replace (x * (1 + eps) + eta - x) with (x * eps + eta) by ring.
  apply Rle_trans with (1 := Rabs_triang _ _). rewrite Rabs_mult.
  assert (E : Rabs eps <= e).
  { apply Rle_trans with (1 := He). unfold e. simpl. lra. }
  assert (N : Rabs eta <= least32).
  { apply Rle_trans with (1 := Hn). unfold least32.
    pose proof (bpow_gt_0 radix2 (-149)). lra. }
  pose proof (Rabs_pos x). nra.
Qed.
Lemma rnd32_pos x : 0 <= x -> 0 <= rnd32 x.
Proof.
  intros H. rewrite <- (round_0 radix2 (FLT_exp (-149) 24) ZnearestE).
  apply round_le; auto with typeclass_instances.
Qed.
(* Of a number that is not negative. *)
Lemma rnd32_between x : 0 <= x ->
  x * (1 - e) - least32 <= rnd32 x <= x * (1 + e) + least32.
Proof.
  intros H. pose proof (rnd32_err x) as E. rewrite (Rabs_pos_eq x H) in E.
  apply Rabs_le_inv in E. lra.
Qed.

(* The square of a rounded difference. *)
Lemma square_between d : Rabs d <= 8 ->
  let q := rnd32 (rnd32 d * rnd32 d) in
  0 <= q /\ d * d * (1 - 4 * e + e * e) - 20 * least32 <= q
  /\ q <= d * d * (1 + 3 * e + 4 * (e * e)) + 20 * least32.
Proof.
  intros D q. pose proof (rnd32_err d) as E. set (f := rnd32 d) in *.
  pose proof least32_pos as P. pose proof least32_small as S.
  assert (F : 0 <= f * f) by nra.
  pose proof (rnd32_between (f * f) F) as B. fold q in B.
  assert (A : Rabs d * Rabs d = d * d) by (rewrite <- Rabs_mult; apply Rabs_pos_eq; nra).
  assert (G : Rabs f * Rabs f = f * f) by (rewrite <- Rabs_mult; apply Rabs_pos_eq; nra).
  pose proof (Rabs_pos d). pose proof (Rabs_pos f).
  assert (U : Rabs f <= Rabs d * (1 + e) + least32).
  { replace f with (f - d + d) by ring. pose proof (Rabs_triang (f - d) d). lra. }
  assert (L : Rabs d * (1 - e) - least32 <= Rabs f).
  { pose proof (Rabs_triang_inv d (d - f)) as T. replace (d - (d - f)) with f in T by ring.
    rewrite (Rabs_minus_sym d f) in T. lra. }
  split; [now apply rnd32_pos|].
  set (x := Rabs d) in *. set (y := Rabs f) in *. rewrite <- A, <- G in *.
  assert (U2 : y * y <= x * x * ((1 + e) * (1 + e)) + 18 * least32).
  { assert (y * y <= (x * (1 + e) + least32) * (x * (1 + e) + least32))
      by (apply Rmult_le_compat; lra).
    unfold e in *. nra. }
  assert (L2 : x * x * ((1 - e) * (1 - e)) - 18 * least32 <= y * y).
  { destruct (Rle_or_lt (x * (1 - e)) least32) as [T|T].
    - assert (x * (1 - e) * (x * (1 - e)) <= least32 * least32)
        by (apply Rmult_le_compat; unfold e in *; lra).
      assert (least32 * least32 <= least32) by nra. nra.
    - assert ((x * (1 - e) - least32) * (x * (1 - e) - least32) <= y * y)
        by (apply Rmult_le_compat; lra).
      assert (0 <= x * (1 - e) <= 8) by (unfold e in *; lra). nra. }
  assert (X : 0 <= x * x) by nra.
  split.
  - apply Rle_trans with (y * y * (1 - e) - least32); [|lra].
    apply Rle_trans with ((x * x * ((1 - e) * (1 - e)) - 18 * least32) * (1 - e) - least32).
    + unfold e in *. nra.
    + apply Rplus_le_compat_r, Rmult_le_compat_r; [unfold e; lra|exact L2].
  - apply Rle_trans with (y * y * (1 + e) + least32); [lra|].
    apply Rle_trans with ((x * x * ((1 + e) * (1 + e)) + 18 * least32) * (1 + e) + least32).
    + apply Rplus_le_compat_r, Rmult_le_compat_r; [unfold e; lra|exact U2].
    + unfold e in *. nra.
Qed.

(* The computed squared distance; [dx], [dy], [dz] are the exact differences of what is stored. *)
Definition distance2 (dx dy dz : R) : R :=
  rnd32 (rnd32 (rnd32 (rnd32 dx * rnd32 dx) + rnd32 (rnd32 dy * rnd32 dy))
         + rnd32 (rnd32 dz * rnd32 dz)).

Lemma distance2_between dx dy dz : Rabs dx <= 8 -> Rabs dy <= 8 -> Rabs dz <= 8 ->
  let s := dx * dx + dy * dy + dz * dz in
  s * (1 - 61 / 10 * e) - 100 * least32 <= distance2 dx dy dz
  /\ distance2 dx dy dz <= s * (1 + 501 / 100 * e) + 100 * least32.
Proof.
  intros X Y Z s. unfold distance2.
  destruct (square_between dx X) as [X0 [X1 X2]].
  destruct (square_between dy Y) as [Y0 [Y1 Y2]].
  destruct (square_between dz Z) as [Z0 [Z1 Z2]].
  set (x := rnd32 (rnd32 dx * rnd32 dx)) in *. set (y := rnd32 (rnd32 dy * rnd32 dy)) in *.
  set (z := rnd32 (rnd32 dz * rnd32 dz)) in *.
  assert (XY : 0 <= x + y) by lra. pose proof (rnd32_between (x + y) XY) as A.
  pose proof (rnd32_pos (x + y) XY) as P. set (w := rnd32 (x + y)) in *.
  assert (WZ : 0 <= w + z) by lra. pose proof (rnd32_between (w + z) WZ) as B.
  pose proof least32_pos as L. unfold s. clear s.
  assert (0 <= dx * dx) by nra. assert (0 <= dy * dy) by nra. assert (0 <= dz * dz) by nra.
  set (p := dx * dx) in *. set (q := dy * dy) in *. set (r := dz * dz) in *.
  unfold e in *. split; nra.
Qed.

(* Distances: non-negative numbers with a given square. *)
Definition length_of (l x y z : R) : Prop := 0 <= l /\ l * l = x * x + y * y + z * z.

Lemma triangle a b d ax ay az bx b_y bz : length_of a ax ay az -> length_of b bx b_y bz ->
  0 <= d -> Rabs (ax - bx) <= d -> Rabs (ay - b_y) <= d -> Rabs (az - bz) <= d ->
  a <= b + 17321 / 10000 * d.
Proof.
  intros [A0 A] [B0 B] D X Y Z.
  set (h1 := ax - bx) in *. set (h2 := ay - b_y) in *. set (h3 := az - bz) in *.
  assert (H1 : h1 * h1 <= d * d) by (apply Rabs_le_inv in X; nra).
  assert (H2 : h2 * h2 <= d * d) by (apply Rabs_le_inv in Y; nra).
  assert (H3 : h3 * h3 <= d * d) by (apply Rabs_le_inv in Z; nra).
  set (k := 17321 / 10000 * d). assert (K0 : 0 <= k) by (unfold k; lra).
  assert (K : h1 * h1 + h2 * h2 + h3 * h3 <= k * k) by (unfold k; nra).
  assert (C : bx * h1 + b_y * h2 + bz * h3 <= b * k).
  { assert (Q : (bx * h1 + b_y * h2 + bz * h3) * (bx * h1 + b_y * h2 + bz * h3)
                <= (b * k) * (b * k)).
    { replace (b * k * (b * k)) with (b * b * (k * k)) by ring. rewrite B.
      apply Rle_trans with ((bx * bx + b_y * b_y + bz * bz) * (h1 * h1 + h2 * h2 + h3 * h3)).
      - apply Rminus_le.
        replace (_ - _) with (- ((bx * h2 - b_y * h1) ^ 2 + (bx * h3 - bz * h1) ^ 2
                                 + (b_y * h3 - bz * h2) ^ 2)) by ring.
        pose proof (pow2_ge_0 (bx * h2 - b_y * h1)). pose proof (pow2_ge_0 (bx * h3 - bz * h1)).
        pose proof (pow2_ge_0 (b_y * h3 - bz * h2)). lra.
      - apply Rmult_le_compat_l; [nra|exact K]. }
    destruct (Rle_or_lt (bx * h1 + b_y * h2 + bz * h3) (b * k)) as [G|G]; [exact G|].
    assert (0 <= b * k) by (now apply Rmult_le_pos). nra. }
  assert (S : a * a <= (b + k) * (b + k)).
  { rewrite A. replace ax with (bx + h1) by (unfold h1; ring).
    replace ay with (b_y + h2) by (unfold h2; ring).
    replace az with (bz + h3) by (unfold h3; ring). nra. }
  destruct (Rle_or_lt a (b + k)) as [G|G]; [exact G|]. nra.
Qed.

(* What is stored of a sphere and a query, and how near it is to the truth: centre c, radius r and
   query q against o, t and p. *)
Record near (cx cy cz r qx qy qz ox oy oz t px py pz : R) : Prop := Near {
  centre_x : Rabs (cx - ox) <= 225 / 100 * e;
  centre_y : Rabs (cy - oy) <= 225 / 100 * e;
  centre_z : Rabs (cz - oz) <= 225 / 100 * e;
  radius : Rabs (r - t) <= 144 / 100 * e;
  query_x : Rabs (qx - px) <= 51 / 100 * e;
  query_y : Rabs (qy - py) <= 51 / 100 * e;
  query_z : Rabs (qz - pz) <= 51 / 100 * e;
  small_radius : 0 <= r <= max_radius;
  small_x : Rabs (qx - cx) <= 8;
  small_y : Rabs (qy - cy) <= 8;
  small_z : Rabs (qz - cz) <= 8
}.

Lemma difference_near a b c d x y : Rabs (a - c) <= x -> Rabs (b - d) <= y ->
  Rabs ((a - b) - (c - d)) <= y + x.
Proof. intros A B. apply Rabs_le_inv in A. apply Rabs_le_inv in B. apply Rabs_le. lra. Qed.

Lemma length_exists x y z : exists l, length_of l x y z.
Proof.
  exists (sqrt (x * x + y * y + z * z)). split; [apply sqrt_pos|]. apply sqrt_sqrt. nra.
Qed.

Section Test.
Variables cx cy cz r qx qy qz ox oy oz t px py pz : R.
Hypothesis N : near cx cy cz r qx qy qz ox oy oz t px py pz.
Let s := distance2 (qx - cx) (qy - cy) (qz - cz).

Theorem outside_correct l : rnd32 (rnd32 (r + tolerance) * rnd32 (r + tolerance)) < s ->
  length_of l (px - ox) (py - oy) (pz - oz) -> t < l.
Proof.
  intros H L. destruct (length_exists (qx - cx) (qy - cy) (qz - cz)) as [d Hd].
  assert (T : d <= l + 17321 / 10000 * (276 / 100 * e)).
  { apply triangle with (1 := Hd) (2 := L); [unfold e; lra| | |];
      (eapply Rle_trans; [apply difference_near; apply N|unfold e; lra]). }
  destruct (distance2_between _ _ _ (small_x _ _ _ _ _ _ _ _ _ _ _ _ _ _ N)
    (small_y _ _ _ _ _ _ _ _ _ _ _ _ _ _ N) (small_z _ _ _ _ _ _ _ _ _ _ _ _ _ _ N))
    as [_ U]. fold s in U.
  destruct Hd as [D0 D]. rewrite <- D in U. clear D L.
  pose proof (small_radius _ _ _ _ _ _ _ _ _ _ _ _ _ _ N) as R.
  pose proof (radius _ _ _ _ _ _ _ _ _ _ _ _ _ _ N) as Q. apply Rabs_le_inv in Q.
  pose proof least32_pos as P. pose proof least32_small as S.
  set (w := r + tolerance) in *. assert (W : 16 * e <= w <= 2 + 16 * e) by (unfold w, tolerance,
      max_radius, e in *; lra).
  assert (W0 : 0 <= w) by (unfold e in W; lra).
  destruct (rnd32_between w W0) as [F _]. pose proof (rnd32_pos w W0) as F0.
  set (f := rnd32 w) in *. destruct (rnd32_between (f * f) ltac:(apply Rmult_le_pos; lra)) as [G _].
  assert (B : w * (1 - 41 / 10 * e) < d).
  { destruct (Rlt_or_le (w * (1 - 41 / 10 * e)) d) as [X|X]; [exact X|exfalso].
    assert (F1 : (w * (1 - e) - least32) * (w * (1 - e) - least32) <= f * f).
    { apply Rmult_le_compat; unfold e in *; lra. }
    assert (X1 : d * d <= w * (1 - 41 / 10 * e) * (w * (1 - 41 / 10 * e))).
    { apply Rmult_le_compat; lra. }
    assert (V : 16 * e * (16 * e) <= w * w) by (apply Rmult_le_compat; unfold e in *; lra).
    assert (E1 : d * d * (1 + 501 / 100 * e)
                 <= w * w * ((1 - 41 / 10 * e) * (1 - 41 / 10 * e) * (1 + 501 / 100 * e))).
    { apply Rle_trans with (w * (1 - 41 / 10 * e) * (w * (1 - 41 / 10 * e))
                            * (1 + 501 / 100 * e)); [|apply Req_le; ring].
      apply Rmult_le_compat_r; [unfold e; lra|exact X1]. }
    assert (E2 : w * w * ((1 - e) * (1 - e) * (1 - e)) - 10 * least32 <= f * f * (1 - e)).
    { apply Rle_trans with ((w * (1 - e) - least32) * (w * (1 - e) - least32) * (1 - e)).
      - replace ((w * (1 - e) - least32) * (w * (1 - e) - least32) * (1 - e))
          with (w * w * ((1 - e) * (1 - e) * (1 - e))
                - 2 * ((1 - e) * (1 - e)) * (w * least32) + (1 - e) * (least32 * least32)) by ring.
        assert (WL : w * least32 <= 3 * least32) by (apply Rmult_le_compat_r; unfold e in *; lra).
        assert (LL : 0 <= least32 * least32) by (apply Rmult_le_pos; lra).
        clear - WL LL P. unfold e. lra.
      - apply Rmult_le_compat_r; [unfold e; lra|exact F1]. }
    assert (E3 : w * w * ((1 - 41 / 10 * e) * (1 - 41 / 10 * e) * (1 + 501 / 100 * e))
                 <= w * w * ((1 - e) * (1 - e) * (1 - e) - 18 / 100 * e)).
    { apply Rmult_le_compat_l; [apply Rmult_le_pos; lra|]. unfold e. lra. }
    assert (E4 : 16 * e * (16 * e) * (18 / 100 * e) <= w * w * (18 / 100 * e)).
    { apply Rmult_le_compat_r; [unfold e; lra|exact V]. }
    unfold e in *. lra. }
  unfold w in B. clear - B T Q R. unfold tolerance, max_radius, e in *. lra.
Qed.

Theorem inside_correct l : s < rnd32 (rnd32 (r - tolerance) * rnd32 (r - tolerance)) ->
  0 < rnd32 (r - tolerance) -> length_of l (px - ox) (py - oy) (pz - oz) -> l < t.
Proof.
  intros H F0 L. destruct (length_exists (qx - cx) (qy - cy) (qz - cz)) as [d Hd].
  assert (T : l <= d + 17321 / 10000 * (276 / 100 * e)).
  { apply triangle with (1 := L) (2 := Hd); [unfold e; lra| | |];
      rewrite Rabs_minus_sym;
      (eapply Rle_trans; [apply difference_near; apply N|unfold e; lra]). }
  destruct (distance2_between _ _ _ (small_x _ _ _ _ _ _ _ _ _ _ _ _ _ _ N)
    (small_y _ _ _ _ _ _ _ _ _ _ _ _ _ _ N) (small_z _ _ _ _ _ _ _ _ _ _ _ _ _ _ N))
    as [U _]. fold s in U.
  destruct Hd as [D0 D]. rewrite <- D in U. clear D L.
  pose proof (small_radius _ _ _ _ _ _ _ _ _ _ _ _ _ _ N) as R.
  pose proof (radius _ _ _ _ _ _ _ _ _ _ _ _ _ _ N) as Q. apply Rabs_le_inv in Q.
  pose proof least32_pos as P. pose proof least32_small as S.
  set (w := r - tolerance) in *.
  assert (W0 : 0 <= w).
  { destruct (Rle_or_lt 0 w) as [G|G]; [exact G|exfalso].
    assert (rnd32 w <= rnd32 0) by (apply round_le; auto with typeclass_instances; lra).
    rewrite round_0 in H0 by auto with typeclass_instances. lra. }
  assert (W : w <= 2) by (unfold w, tolerance, max_radius, e in *; lra).
  destruct (rnd32_between w W0) as [_ F].
  set (f := rnd32 w) in *. destruct (rnd32_between (f * f) ltac:(apply Rmult_le_pos; lra)) as [_ G].
  set (z := / 1000000000000000). (* far below e, its square far above the underflow *)
  assert (B : d <= w * (1 + 46 / 10 * e) + z).
  { destruct (Rle_or_lt d (w * (1 + 46 / 10 * e) + z)) as [X|X]; [exact X|exfalso].
    assert (F1 : f * f <= (w * (1 + e) + least32) * (w * (1 + e) + least32)).
    { apply Rmult_le_compat; lra. }
    assert (X1 : (w * (1 + 46 / 10 * e) + z) * (w * (1 + 46 / 10 * e) + z) <= d * d).
    { assert (0 <= w * (1 + 46 / 10 * e)) by (apply Rmult_le_pos; unfold e; lra).
      apply Rmult_le_compat; unfold z in *; lra. }
    assert (X2 : w * w * ((1 + 46 / 10 * e) * (1 + 46 / 10 * e)) + z * z <= d * d).
    { apply Rle_trans with (2 := X1).
      assert (0 <= w * (1 + 46 / 10 * e) * z).
      { apply Rmult_le_pos; [apply Rmult_le_pos; unfold e; lra|unfold z; lra]. }
      lra. }
    assert (WW : 0 <= w * w) by (apply Rmult_le_pos; lra).
    assert (E1 : (w * w * ((1 + 46 / 10 * e) * (1 + 46 / 10 * e)) + z * z) * (1 - 61 / 10 * e)
                 <= d * d * (1 - 61 / 10 * e)).
    { apply Rmult_le_compat_r; [unfold e; lra|exact X2]. }
    assert (E2 : f * f * (1 + e) <= w * w * ((1 + e) * (1 + e) * (1 + e)) + 10 * least32).
    { apply Rle_trans with ((w * (1 + e) + least32) * (w * (1 + e) + least32) * (1 + e)).
      - apply Rmult_le_compat_r; [unfold e; lra|exact F1].
      - replace ((w * (1 + e) + least32) * (w * (1 + e) + least32) * (1 + e))
          with (w * w * ((1 + e) * (1 + e) * (1 + e))
                + 2 * ((1 + e) * (1 + e)) * (w * least32) + (1 + e) * (least32 * least32)) by ring.
        assert (WL : w * least32 <= 3 * least32) by (apply Rmult_le_compat_r; lra).
        assert (LL : least32 * least32 <= 1 * least32) by (apply Rmult_le_compat_r; lra).
        clear - WL LL P. unfold e. lra. }
    assert (E3 : w * w * ((1 + e) * (1 + e) * (1 + e))
                 <= w * w * ((1 + 46 / 10 * e) * (1 + 46 / 10 * e) * (1 - 61 / 10 * e))).
    { apply Rmult_le_compat_l; [exact WW|]. unfold e. lra. }
    assert (E4 : 200 * least32 <= z * z * (1 - 61 / 10 * e)) by (unfold z, e; lra).
    lra. }
  unfold w in B. clear - B T Q R. unfold tolerance, max_radius, z, e in *. lra.
Qed.
End Test.
