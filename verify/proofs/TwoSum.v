(* ltbw: the exact stages take differences as a rounded value and its error, without loss.
   Licence: MIT OR Apache-2.0. Checked by `cargo xtask prove`. *)
Require Import Reals ZArith Lia Psatz.
From Flocq Require Import Core Pff.Pff2Flocq.
Require Import Rounding.
Open Scope R_scope.

(* As in core/exact/src/predicates/exact/differences.rs. *)
Definition high (a b : R) : R := rnd (a - b).
Definition b_virtual (a b : R) : R := rnd (a - high a b).
Definition a_virtual (a b : R) : R := rnd (high a b + b_virtual a b).
Definition low (a b : R) : R :=
  rnd (rnd (a - a_virtual a b) + rnd (b_virtual a b - b)).

Theorem two_difference_exact a b : float a -> float b -> high a b + low a b = a - b.
Proof.
  intros A B.
  assert (S : forall x, negb (Z.even x) = negb (negb (Z.even (- (x + 1))))).
  { intros x. rewrite Z.even_opp, Z.add_1_r, Z.even_succ, <- Z.negb_even.
    now destruct (Z.even x). }
  assert (T := TwoSum_correct emin prec (fun z => negb (Z.even z)) eq_refl ltac:(easy) S
    a (- b) A (generic_format_opp _ _ _ B)).
  change (rnd (a + - b)) with (high a b) in T.
  assert (V : rnd (high a b - a) = - b_virtual a b).
  { unfold b_virtual. rewrite <- round_NE_opp. f_equal. ring. }
  rewrite V in T.
  replace (high a b - - b_virtual a b) with (high a b + b_virtual a b) in T by ring.
  replace (- b - - b_virtual a b) with (b_virtual a b - b) in T by ring.
  exact T.
Qed.
