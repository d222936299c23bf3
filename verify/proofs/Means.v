(* ltbw: what the predicates mean, and the theorems about their filters.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   Written by hand, beside the generated terms: each exact value is the textbook's. So a mistake in
   a description cannot go unseen. *)
Require Import Reals NArith ZArith List Lia Psatz Bool.
From Flocq Require Import Core.
Require Import Rounding Poly Expr Bound Filter Exact Predicates.
Import ListNotations.
Open Scope R_scope.

(* Vectors. *)
Definition vector := (R * R * R)%type.
Definition minus (a b : vector) : vector :=
  match a, b with (x, y, z), (x', y', z') => (x - x', y - y', z - z') end.
Definition dot (a b : vector) : R :=
  match a, b with (x, y, z), (x', y', z') => x * x' + y * y' + z * z' end.
Definition cross (a b : vector) : vector :=
  match a, b with
  | (x, y, z), (x', y', z') => (y * z' - z * y', z * x' - x * z', x * y' - y * x')
  end.
Definition scale (s : R) (a : vector) : vector :=
  match a with (x, y, z) => (s * x, s * y, s * z) end.
Definition plus (a b : vector) : vector :=
  match a, b with (x, y, z), (x', y', z') => (x + x', y + y', z + z') end.
Definition norm2 (a : vector) : R := dot a a.

(* The points of an input of three coordinates each. *)
Definition point (c : nat -> R) (k : nat) : vector :=
  (c (3 * k)%nat, c (3 * k + 1)%nat, c (3 * k + 2)%nat).

Lemma constant_integer n : constant n 0 = IZR (Z.of_N n).
Proof. unfold constant. simpl. ring. Qed.

(* Unfolds everything but the operations on real numbers. *)
Ltac expand :=
  cbv -[Rplus Rminus Rmult Ropp Rinv Rmin IZR constant]; rewrite ?constant_integer; simpl Z.of_N.

(* det(b - a, c - a, d - a), positive for the unit tetrahedron. *)
Definition orientation (a b c d : vector) : R :=
  dot (minus b a) (cross (minus c a) (minus d a)).

Theorem orient3d_means c : - exact_value orient3d c
  = orientation (point c 0) (point c 1) (point c 2) (point c 3).
Proof. expand. ring. Qed.

(* For a tetrahedron with its orientation positive, e is inside the sphere of centre o through
   a, b, c and d exactly if this is positive. *)
Definition sphere_side (a b c d e : vector) : R :=
  let u := minus a e in let v := minus b e in let w := minus c e in let t := minus d e in
  norm2 u * dot v (cross w t) - norm2 v * dot u (cross w t)
  + norm2 w * dot u (cross v t) - norm2 t * dot u (cross v w).

Theorem insphere_means c : - exact_value insphere c
  = sphere_side (point c 0) (point c 1) (point c 2) (point c 3) (point c 4).
Proof. expand. ring. Qed.

Theorem sphere_side_means a b c d e o r :
  norm2 (minus a o) = r -> norm2 (minus b o) = r -> norm2 (minus c o) = r ->
  norm2 (minus d o) = r ->
  sphere_side a b c d e = orientation a b c d * (r - norm2 (minus e o)).
Proof.
  intros A B C D.
  assert (I : sphere_side a b c d e =
    let u := minus a e in let v := minus b e in let w := minus c e in let t := minus d e in
    dot v (cross w t) * norm2 (minus a o) - dot u (cross w t) * norm2 (minus b o)
    + dot u (cross v t) * norm2 (minus c o) - dot u (cross v w) * norm2 (minus d o)
    - orientation a b c d * norm2 (minus e o)).
  { destruct a as [[ax ay] az], b as [[bx by_] bz], c as [[cx cy] cz], d as [[dx dy] dz],
      e as [[e_x ey] ez], o as [[ox oy] oz]. expand. ring. }
  rewrite I, A, B, C, D. clear I A B C D.
  destruct a as [[ax ay] az], b as [[bx by_] bz], c as [[cx cy] cz], d as [[dx dy] dz],
    e as [[e_x ey] ez]. generalize (norm2 (minus (e_x, ey, ez) o)). intros q. expand. ring.
Qed.

(* Projections: two numbers a point. *)
Theorem orient2d_means c : exact_value orient2d c
  = (c 0%nat - c 4%nat) * (c 3%nat - c 5%nat) - (c 1%nat - c 5%nat) * (c 2%nat - c 4%nat).
Proof. expand. ring. Qed.

(* x, y, z and the two numbers i, j of a projection, five a point. *)
Definition lift (c : nat -> R) (k l : nat) : R :=
  norm2 (minus (c (5 * k)%nat, c (5 * k + 1)%nat, c (5 * k + 2)%nat)
               (c (5 * l)%nat, c (5 * l + 1)%nat, c (5 * l + 2)%nat)).
Definition turn (c : nat -> R) (k l m : nat) : R :=
  (c (5 * k + 3)%nat - c (5 * m + 3)%nat) * (c (5 * l + 4)%nat - c (5 * m + 4)%nat)
  - (c (5 * k + 4)%nat - c (5 * m + 4)%nat) * (c (5 * l + 3)%nat - c (5 * m + 3)%nat).
Theorem incircle_means c : exact_value incircle c
  = lift c 0 3 * turn c 1 2 3 - lift c 1 3 * turn c 0 2 3 + lift c 2 3 * turn c 0 1 3.
Proof. expand. ring. Qed.

(* The squared radius minus the squared distance to the centre, the midpoint of a and b. *)
Theorem in_diametral_ball_means c :
  let a := point c 0 in let b := point c 1 in let p := point c 2 in
  - exact_value in_diametral_ball c
  = norm2 (minus a b) / 4 - norm2 (minus p (scale (/ 2) (plus a b))).
Proof. expand. field. Qed.

(* The centre of the circle through a, b and c is a - s u - t v, with u = a - b and v = a - c. *)
Theorem in_equatorial_ball_means c s t :
  let a := point c 0 in let b := point c 1 in let d := point c 2 in let p := point c 3 in
  let u := minus a b in let v := minus a d in
  let o := minus a (plus (scale s u) (scale t v)) in
  norm2 (minus b o) = norm2 (minus a o) -> norm2 (minus d o) = norm2 (minus a o) ->
  - exact_value in_equatorial_ball c
  = norm2 (cross u v) * (norm2 (minus a o) - norm2 (minus p o)).
Proof.
  intros a b d p u v o B C. set (w := minus a p).
  assert (E : exact_value in_equatorial_ball c
    = norm2 (cross u v) * norm2 w
      - norm2 v * (norm2 u - dot u v) * dot w u - norm2 u * (norm2 v - dot u v) * dot w v).
  { unfold w, u, v, a, b, d, p. expand. ring. }
  assert (E1 : norm2 u = 2 * (s * norm2 u + t * dot u v)).
  { apply Rminus_diag_uniq. apply Rminus_diag_eq in B. rewrite <- B.
    unfold o, u, v. destruct a as [[ax ay] az], b as [[bx by_] bz], d as [[dx dy] dz].
    expand. ring. }
  assert (E2 : norm2 v = 2 * (s * dot u v + t * norm2 v)).
  { apply Rminus_diag_uniq. apply Rminus_diag_eq in C. rewrite <- C.
    unfold o, u, v. destruct a as [[ax ay] az], b as [[bx by_] bz], d as [[dx dy] dz].
    expand. ring. }
  assert (G : norm2 (cross u v) = norm2 u * norm2 v - dot u v * dot u v).
  { destruct u as [[ux uy] uz], v as [[vx vy] vz]. expand. ring. }
  assert (P : norm2 (minus a o) - norm2 (minus p o)
              = 2 * (s * dot w u + t * dot w v) - norm2 w).
  { unfold o, w. destruct a as [[ax ay] az], p as [[px py] pz], u as [[ux uy] uz],
      v as [[vx vy] vz]. expand. ring. }
  rewrite E, P, G.
  assert (X : norm2 v * (norm2 u - dot u v) = 2 * s * (norm2 u * norm2 v - dot u v * dot u v)).
  { transitivity (norm2 v * (2 * (s * norm2 u + t * dot u v))
                  - dot u v * (2 * (s * dot u v + t * norm2 v))); [|ring].
    rewrite <- E1, <- E2. ring. }
  assert (Y : norm2 u * (norm2 v - dot u v) = 2 * t * (norm2 u * norm2 v - dot u v * dot u v)).
  { transitivity (norm2 u * (2 * (s * dot u v + t * norm2 v))
                  - dot u v * (2 * (s * norm2 u + t * dot u v))); [|ring].
    rewrite <- E1, <- E2. ring. }
  rewrite X, Y. ring.
Qed.

(* With o the centre of the sphere and l the shortest edge: a multiple of R^2 - (ratio l)^2. *)
Definition shortest2 (a b c d : vector) : R :=
  Rmin (Rmin (Rmin (norm2 (minus a d)) (norm2 (minus b d))) (norm2 (minus c d)))
       (Rmin (Rmin (norm2 (minus a b)) (norm2 (minus b c))) (norm2 (minus c a))).
Theorem exceeds_radius_edge_means c o r :
  let a := point c 0 in let b := point c 1 in let d := point c 2 in let e := point c 3 in
  let ratio := c 12%nat in
  norm2 (minus a o) = r -> norm2 (minus b o) = r -> norm2 (minus d o) = r ->
  norm2 (minus e o) = r ->
  exact_value exceeds_radius_edge c
  = 4 * (orientation a b d e * orientation a b d e) * (r - ratio * ratio * shortest2 a b d e).
Proof.
  intros a b d e ratio A B C D.
  set (u := minus a e). set (v := minus b e). set (w := minus d e). set (f := minus o e).
  set (n := plus (scale (norm2 u) (cross v w))
                 (plus (scale (norm2 v) (cross w u)) (scale (norm2 w) (cross u v)))).
  set (k := dot u (cross v w)).
  assert (E : exact_value exceeds_radius_edge c
    = norm2 n - 4 * (ratio * ratio) * (k * k) * shortest2 a b d e).
  { unfold shortest2.
    assert (S : ex (exact exceeds_radius_edge c) exceeds_radius_edge_shortest
                = shortest2 a b d e) by reflexivity.
    change (exact_value exceeds_radius_edge c) with
      (ex (exact exceeds_radius_edge c)
         (Add (Add (Mul exceeds_radius_edge_nx exceeds_radius_edge_nx)
                   (Mul exceeds_radius_edge_ny exceeds_radius_edge_ny))
              (Mul exceeds_radius_edge_nz exceeds_radius_edge_nz))
       - ex (exact exceeds_radius_edge c)
           (Mul exceeds_radius_edge_limit exceeds_radius_edge_limit)
         * ex (exact exceeds_radius_edge c) exceeds_radius_edge_shortest).
    rewrite S. fold (shortest2 a b d e). generalize (shortest2 a b d e). intros l.
    unfold n, k, u, v, w, a, b, d, e, ratio. expand. ring. }
  assert (H : forall q g, norm2 (minus q o) = r -> norm2 (minus g o) = r ->
                norm2 (minus q g) = 2 * dot (minus q g) (minus o g)).
  { intros q g Q G. rewrite <- G in Q. apply Rminus_diag_eq in Q. apply Rminus_diag_uniq.
    rewrite <- Q. destruct q as [[qx qy] qz], g as [[gx gy] gz], o as [[ox oy] oz].
    expand. ring. }
  assert (N : n = scale (2 * k) f).
  { unfold n. rewrite (H a e A D : norm2 u = 2 * dot u f).
    rewrite (H b e B D : norm2 v = 2 * dot v f). rewrite (H d e C D : norm2 w = 2 * dot w f).
    unfold k. destruct u as [[ux uy] uz], v as [[vx vy] vz], w as [[wx wy] wz],
      f as [[fx fy] fz]. expand. f_equal; [f_equal|]; ring. }
  assert (K : k = - orientation a b d e).
  { unfold k, u, v, w. destruct a as [[ax ay] az], b as [[bx by_] bz], d as [[dx dy] dz],
      e as [[e_x ey] ez]. expand. ring. }
  assert (F : norm2 f = r).
  { rewrite <- D. unfold f. destruct e as [[e_x ey] ez], o as [[ox oy] oz]. expand. ring. }
  rewrite E, N.
  assert (M : norm2 (scale (2 * k) f) = 4 * (k * k) * norm2 f).
  { destruct f as [[fx fy] fz]. generalize k. intros. expand. ring. }
  rewrite M, F, K. ring.
Qed.

Theorem exceeds_volume_means c : exact_value exceeds_volume c
  = orientation (point c 0) (point c 1) (point c 2) (point c 3) - 6 * c 12%nat.
Proof. expand. ring. Qed.

(* With s and t the lengths of the normals of the faces at ab, and x the cosine of the angle between
   them, the dihedral one at ab: a multiple of x^2 - cos2. *)
Theorem below_dihedral_means c s t x :
  let a := point c 0 in let b := point c 1 in let d := point c 2 in let e := point c 3 in
  let p := cross (minus b a) (minus d a) in let q := cross (minus b a) (minus e a) in
  let cos2 := c 12%nat in
  norm2 p = s * s -> norm2 q = t * t -> dot p q = s * t * x ->
  exact_value below_dihedral c = (s * t) * (s * t) * (x * x - cos2).
Proof.
  intros a b d e p q cos2 P Q D.
  assert (F : forall g, cross (minus b a) (minus g a) = cross (minus a b) (minus a g)).
  { intros g. destruct a as [[ax ay] az], b as [[bx by_] bz], g as [[gx gy] gz].
    expand. f_equal; [f_equal|]; ring. }
  assert (E : exact_value below_dihedral c
    = let m := cross (minus a b) (minus a d) in let n := cross (minus a b) (minus a e) in
      dot m n * dot m n - cos2 * (norm2 m * norm2 n)) by reflexivity.
  rewrite E. rewrite <- !F. fold p q. cbv zeta. rewrite P, Q, D. ring.
Qed.

(* A sign that the comparison with the bound gives is that of the exact value. *)
Definition certain (computed bound exact : R) : Prop :=
  (bound < computed -> 0 < exact) /\ (bound < - computed -> exact < 0).
Lemma certain_by v b x : Rabs (v - x) <= b -> certain v b x.
Proof. intros H. apply Rabs_le_inv in H. split; lra. Qed.
Lemma certain_opp v b x : Rabs (v - x) <= b -> certain (- v) b (- x).
Proof. intros H. apply Rabs_le_inv in H. split; lra. Qed.

(* What the filters for any coordinates ask for. *)
Definition guarded (F : filter) (c : nat -> R) : Prop :=
  (forall i, float (c i)) /\
  forall t, (0 < t < length (extents F))%nat ->
    bpow radix2 (low_guard F t) <= sizes F 0 c t <= bpow radix2 (high_guard F t).
(* Nothing that is computed leaves the range of binary64. *)
Definition no_overflow (F : filter) (c : nat -> R) : Prop :=
  finite (computed F c) (value F) /\ finite (sizes F 0 c) (bound F).

Definition spatial (c : nat -> R) := orientation (point c 0) (point c 1) (point c 2) (point c 3).
Definition spherical (c : nat -> R) :=
  sphere_side (point c 0) (point c 1) (point c 2) (point c 3) (point c 4).

Theorem orient3d_window_correct c : (forall i, in_window (c i)) ->
  certain (- fl_value orient3d c) (fl_bound orient3d c) (spatial c) /\ no_overflow orient3d c.
Proof.
  intros W. destruct (window_sound orient3d c orient3d_window W) as [E N]. split; [|exact N].
  unfold spatial. rewrite <- orient3d_means. now apply certain_opp.
Qed.
Theorem orient3d_any_correct c : guarded orient3d c ->
  certain (- fl_value orient3d c) (fl_bound orient3d c) (spatial c) /\ no_overflow orient3d c.
Proof.
  intros [C G]. destruct (guard_sound orient3d c orient3d_guard C G) as [E N].
  split; [|exact N]. unfold spatial. rewrite <- orient3d_means. now apply certain_opp.
Qed.
Theorem orient3d_no_extent_correct c t : (0 < t < 4)%nat -> (forall i, float (c i)) ->
  sizes orient3d 0 c t = 0 -> spatial c = 0.
Proof.
  intros T C Z. unfold spatial. rewrite <- orient3d_means.
  rewrite (no_extent_is_zero orient3d c t); auto; [ring|].
  destruct t as [|[|[|[|t]]]]; try lia;
    [exact orient3d_no_mx|exact orient3d_no_my|exact orient3d_no_mz].
Qed.
Theorem orient3d_lattice_correct c k s : (-194 <= s)%Z ->
  (forall i, c i = IZR (k i) * bpow radix2 s) ->
  (forall n, Rabs (computed orient3d c n) <= IZR (Z.of_N (2 ^ 16)) * bpow radix2 s) ->
  - fl_value orient3d c = spatial c.
Proof.
  intros S E L. unfold spatial. rewrite <- orient3d_means. f_equal.
  exact (lattice_sound (2 ^ 16) orient3d c k s orient3d_lattice S E L).
Qed.

Theorem insphere_window_correct c : (forall i, in_window (c i)) ->
  certain (- fl_value insphere c) (fl_bound insphere c) (spherical c) /\ no_overflow insphere c.
Proof.
  intros W. destruct (window_sound insphere c insphere_window W) as [E N]. split; [|exact N].
  unfold spherical. rewrite <- insphere_means. now apply certain_opp.
Qed.
Theorem insphere_any_correct c : guarded insphere c ->
  certain (- fl_value insphere c) (fl_bound insphere c) (spherical c) /\ no_overflow insphere c.
Proof.
  intros [C G]. destruct (guard_sound insphere c insphere_guard C G) as [E N].
  split; [|exact N]. unfold spherical. rewrite <- insphere_means. now apply certain_opp.
Qed.
Theorem insphere_no_extent_correct c t : (0 < t < 4)%nat -> (forall i, float (c i)) ->
  sizes insphere 0 c t = 0 -> spherical c = 0.
Proof.
  intros T C Z. unfold spherical. rewrite <- insphere_means.
  rewrite (no_extent_is_zero insphere c t); auto; [ring|].
  destruct t as [|[|[|[|t]]]]; try lia;
    [exact insphere_no_mx|exact insphere_no_my|exact insphere_no_mz].
Qed.
Theorem insphere_lattice_correct c k s : (-194 <= s)%Z ->
  (forall i, c i = IZR (k i) * bpow radix2 s) ->
  (forall n, Rabs (computed insphere c n) <= IZR (Z.of_N (2 ^ 9)) * bpow radix2 s) ->
  - fl_value insphere c = spherical c.
Proof.
  intros S E L. unfold spherical. rewrite <- insphere_means. f_equal.
  exact (lattice_sound (2 ^ 9) insphere c k s insphere_lattice S E L).
Qed.

Theorem orient2d_any_correct c : guarded orient2d c ->
  certain (fl_value orient2d c) (fl_bound orient2d c) (exact_value orient2d c)
  /\ no_overflow orient2d c.
Proof.
  intros [C G]. destruct (guard_sound orient2d c orient2d_guard C G) as [E N].
  split; [now apply certain_by|exact N].
Qed.
Theorem orient2d_no_extent_correct c t : (0 < t < 3)%nat -> (forall i, float (c i)) ->
  sizes orient2d 0 c t = 0 -> exact_value orient2d c = 0.
Proof.
  intros T C Z. apply (no_extent_is_zero orient2d c t); auto.
  destruct t as [|[|[|t]]]; try lia; [exact orient2d_no_mi|exact orient2d_no_mj].
Qed.
Theorem incircle_any_correct c : guarded incircle c ->
  certain (fl_value incircle c) (fl_bound incircle c) (exact_value incircle c)
  /\ no_overflow incircle c.
Proof.
  intros [C G]. destruct (guard_sound incircle c incircle_guard C G) as [E N].
  split; [now apply certain_by|exact N].
Qed.
Theorem incircle_no_extent_correct c t : (0 < t < 3)%nat -> (forall i, float (c i)) ->
  sizes incircle 0 c t = 0 -> exact_value incircle c = 0.
Proof.
  intros T C Z. apply (no_extent_is_zero incircle c t); auto.
  destruct t as [|[|[|t]]]; try lia; [exact incircle_no_mi|exact incircle_no_mj].
Qed.

Theorem in_diametral_ball_any_correct c : guarded in_diametral_ball c ->
  certain (- fl_value in_diametral_ball c) (fl_bound in_diametral_ball c)
          (- exact_value in_diametral_ball c)
  /\ no_overflow in_diametral_ball c.
Proof.
  intros [C G]. destruct (guard_sound in_diametral_ball c in_diametral_ball_guard C G) as [E N].
  split; [now apply certain_opp|exact N].
Qed.
Theorem in_equatorial_ball_any_correct c : guarded in_equatorial_ball c ->
  certain (- fl_value in_equatorial_ball c) (fl_bound in_equatorial_ball c)
          (- exact_value in_equatorial_ball c)
  /\ no_overflow in_equatorial_ball c.
Proof.
  intros [C G].
  destruct (guard_sound in_equatorial_ball c in_equatorial_ball_guard C G) as [E N].
  split; [now apply certain_opp|exact N].
Qed.
Theorem exceeds_radius_edge_any_correct c : guarded exceeds_radius_edge c ->
  certain (fl_value exceeds_radius_edge c) (fl_bound exceeds_radius_edge c)
          (exact_value exceeds_radius_edge c)
  /\ no_overflow exceeds_radius_edge c.
Proof.
  intros [C G].
  destruct (guard_sound exceeds_radius_edge c exceeds_radius_edge_guard C G) as [E N].
  split; [now apply certain_by|exact N].
Qed.
Theorem exceeds_volume_any_correct c : guarded exceeds_volume c ->
  certain (fl_value exceeds_volume c) (fl_bound exceeds_volume c) (exact_value exceeds_volume c)
  /\ no_overflow exceeds_volume c.
Proof.
  intros [C G]. destruct (guard_sound exceeds_volume c exceeds_volume_guard C G) as [E N].
  split; [now apply certain_by|exact N].
Qed.
Theorem below_dihedral_any_correct c : guarded below_dihedral c ->
  certain (fl_value below_dihedral c) (fl_bound below_dihedral c) (exact_value below_dihedral c)
  /\ no_overflow below_dihedral c.
Proof.
  intros [C G]. destruct (guard_sound below_dihedral c below_dihedral_guard C G) as [E N].
  split; [now apply certain_by|exact N].
Qed.

(* The exact stages in floating point, and the products of the in-sphere test in 128 bits. *)
Lemma few_bits_orient3d : exact_within (2 ^ 16) (value orient3d) = true.
Proof. vm_compute. reflexivity. Qed.
Lemma few_bits_insphere : exact_within (2 ^ 9) (value insphere) = true.
Proof. vm_compute. reflexivity. Qed.
Lemma few_bits_insphere_factors :
  forallb (exact_within (2 ^ 16))
    [insphere_abc; insphere_bcd; insphere_cda; insphere_dab;
     insphere_alift; insphere_blift; insphere_clift; insphere_dlift] = true.
Proof. vm_compute. reflexivity. Qed.
Lemma few_bits_insphere_products :
  forallb (fun p => N.ltb (magnitude (2 ^ 16) p) (2 ^ 127)) (parts (value insphere)) = true.
Proof. vm_compute. reflexivity. Qed.
