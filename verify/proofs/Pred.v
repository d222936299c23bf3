(* ltbw: the instances of Filter.v: orient3d and insphere.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`.

   In Shewchuk's order of evaluation, which core/src/predicates follows. Constants:
   orient3d (2^49+1)/2^99, insphere (2^48+1)/2^97 times the permanent.
   Filter.v must be compiled first. *)
Require Import Filter QArith Reals ZArith.
From Flocq Require Import Core.
(* leaves: 0..2 = adx ady adz, 3..5 = b, 6..8 = c (, 9..11 = d) *)
Definition a (i:nat) := V i. Definition b (i:nat) := V (3+i). Definition c (i:nat) := V (6+i). Definition d (i:nat) := V (9+i).
Definition minor (p q : nat -> expr) := Sub (Mul (p 0%nat) (q 1%nat)) (Mul (q 0%nat) (p 1%nat)).
(* Shewchuk's / robust-1.2 order *)
Definition orient3d := Add (Add (Mul (a 2) (minor b c)) (Mul (b 2) (minor c a))) (Mul (c 2) (minor a b)).
Definition lift (p : nat -> expr) := Add (Add (Mul (p 0%nat) (p 0%nat)) (Mul (p 1%nat) (p 1%nat))) (Mul (p 2%nat) (p 2%nat)).
Definition ab := minor a b. Definition bc := minor b c. Definition cd := minor c d. Definition da := minor d a. Definition ac := minor a c. Definition bd := minor b d.
Definition abc := Add (Sub (Mul (a 2) bc) (Mul (b 2) ac)) (Mul (c 2) ab).
Definition bcd := Add (Sub (Mul (b 2) cd) (Mul (c 2) bd)) (Mul (d 2) bc).
Definition cda := Add (Add (Mul (c 2) da) (Mul (d 2) ac)) (Mul (a 2) cd).
Definition dab := Add (Add (Mul (d 2) ab) (Mul (a 2) bd)) (Mul (b 2) da).
Definition insphere := Add (Sub (Mul (lift d) abc) (Mul (lift c) dab)) (Sub (Mul (lift b) cda) (Mul (lift a) bcd)).
Definition orient2d := Sub (Mul (V 0) (V 1)) (Mul (V 2) (V 3)).

Definition ceilu (x : Q) : Z := (* ceil of (x / u * 1000) : constant in milli-u *) 
  (- ((- (Qnum x * 2^53 * 1000)) / Zpos (Qden x)))%Z.
Eval vm_compute in (ceilu (Qred (k orient2d / s orient2d))).
Eval vm_compute in (ceilu (Qred (k orient3d / s orient3d))).
Eval vm_compute in (ceilu (Qred (k insphere / s insphere))).
Eval vm_compute in (deg orient3d, deg insphere).

(* certified constants, as exact dyadics *)
Definition C_o3d : Q := 14001 # (1000 * 2^53).
Definition C_isp : Q := 26001 # (1000 * 2^53).
Definition second (n:Z) (e:expr) := (let x := Qred (k e / s e) in (* ((x/u) - n)/u, ceil *) 
   - ((- ((Qnum x * 2^53 - n * Zpos (Qden x)) * 2^53)) / Zpos (Qden x)))%Z.
Eval vm_compute in (second 4 orient2d, second 8 orient3d, second 16 insphere).

(* certified binary64 constants: (8+64u)u and (16+...)u rounded up to a double: 8u*(1+2^-50), 16u*(1+2^-48) -- multiples of 2^-102, 2^-100 *)
Definition Cf_o3d : Q := (2^49 + 1) # (2^99).
Definition Cf_isp : Q := (2^48 + 1) # (2^97).
Lemma o3d_ok : (k orient3d <= Cf_o3d * (1 - uq) * s orient3d)%Q.  Proof. vm_compute. discriminate. Qed.
Lemma isp_ok : (k insphere <= Cf_isp * (1 - uq) * s insphere)%Q.  Proof. vm_compute. discriminate. Qed.
Require Import Qreals Lia Lra.
Open Scope R_scope.
Lemma dy (k m : Z) : (0 <= m)%Z -> generic_format radix2 (FIX_exp (-m)) (IZR k * bpow radix2 (-m)).
Proof. intros. apply generic_format_FIX. exists (Float radix2 k (-m)); reflexivity. Qed.
Notation rnd := (round radix2 (FLT_exp emin prec) ZnearestE).

Theorem orient3d_filter (f x : nat -> R) :
  (forall n, generic_format radix2 (FIX_exp (-194)) (f n)) ->
  (forall n, Rabs (f n - x n) <= u * Rabs (f n)) ->
  (rnd (Q2R Cf_o3d * pfl f orient3d) < fl f orient3d -> 0 < ex x orient3d) /\
  (fl f orient3d < - rnd (Q2R Cf_o3d * pfl f orient3d) -> ex x orient3d < 0).
Proof.
intros Hm Hl. apply (filter_sound_fl 194 ltac:(lia) f x Hm Hl orient3d Cf_o3d 99); try (simpl; lia); [|discriminate|apply o3d_ok].
replace (Q2R Cf_o3d) with (IZR (2^49+1) * bpow radix2 (-99)). apply dy; lia.
unfold Q2R, Cf_o3d, Qnum, Qden. f_equal.
Qed.
Theorem insphere_filter (f x : nat -> R) :
  (forall n, generic_format radix2 (FIX_exp (-194)) (f n)) ->
  (forall n, Rabs (f n - x n) <= u * Rabs (f n)) ->
  (rnd (Q2R Cf_isp * pfl f insphere) < fl f insphere -> 0 < ex x insphere) /\
  (fl f insphere < - rnd (Q2R Cf_isp * pfl f insphere) -> ex x insphere < 0).
Proof.
intros Hm Hl. apply (filter_sound_fl 194 ltac:(lia) f x Hm Hl insphere Cf_isp 97); try (simpl; lia); [|discriminate|apply isp_ok].
replace (Q2R Cf_isp) with (IZR (2^48+1) * bpow radix2 (-97)). apply dy; lia.
unfold Q2R, Cf_isp, Qnum, Qden. f_equal.
Qed.
Print Assumptions insphere_filter.
