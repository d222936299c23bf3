//! The choice among the candidates of a round, by the tetrahedra in their cavities: one is killed,
//! or waits, for those before it. Where some have to be alone in their closures candidates
//! have turns, the foremost first.

use super::choice::Rival;
use super::watch::Watch;
use crate::complex::carrier::Carrier;

/// At patches each wave of probes has twice the ranks of the wave before it, the first has one, up
/// to this number; then come all others.
const SMALL: usize = 64;

/// The number of ranks in the wave of probes after one of `count`, of `all` ranks; the first one
/// comes after none.
#[doc(hidden)]
pub fn next_wave(count: usize, all: usize) -> usize {
    match count {
        0 => 1,
        count if count < SMALL => 2 * count,
        _ => all,
    }
}

/// The tetrahedra that the candidates of a round have in their cavities.
#[doc(hidden)]
pub trait Held {
    /// A tetrahedron.
    type Tet: Copy;

    /// The rank of the foremost candidate with a tetrahedron in its cavity.
    fn holder(&self, t: Self::Tet) -> Option<usize>;

    /// Has the candidate of a rank to be alone?
    fn is_alone(&self, rank: usize) -> bool;

    /// Has any?
    fn has_alone(&self) -> bool;

    /// The number of boundary items, which have the first ranks.
    fn of_boundary(&self) -> usize;

    /// Where the point of a boundary item lives.
    fn carrier(&self, rank: usize) -> Carrier;

    /// Rule (d) for points of the boundary in turns: is a tetrahedron in the cavity of one that was
    /// taken before, and is not of the same segment or facet as one on `carrier`?
    fn bars(&self, t: Self::Tet, carrier: Carrier) -> bool {
        self.holder(t).is_some_and(|other| !self.carrier(other).is_with(carrier))
    }
}

/// A candidate of a round.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Contender<'c, T> {
    /// Its rank.
    pub rank: usize,
    /// The tetrahedron that it splits, if it is none of the boundary.
    pub tet: Option<T>,
    /// Where its point lives.
    pub carrier: Carrier,
    /// The tetrahedra at which others before it make it wait.
    pub watch: Option<&'c Watch<T>>,
    /// Has it to be the foremost in its whole closure, and to be left alone there?
    pub is_alone: bool,
}

impl<T: Copy> Contender<'_, T> {
    /// The rank of the foremost candidate before it that has a tetrahedron in its cavity.
    #[inline(always)]
    fn before<H: Held<Tet = T>>(&self, held: &H, t: T) -> Option<usize> {
        held.holder(t).filter(|&other| other < self.rank)
    }

    fn rival<H: Held<Tet = T>>(&self, held: &H, t: T) -> Rival {
        let Some(other) = self.before(held, t) else { return Rival::default() };
        let is_boundary = other < held.of_boundary();
        let is_apart = is_boundary && !held.carrier(other).is_with(self.carrier);
        Rival { is_there: true, is_boundary, is_apart }
    }

    /// Is its tetrahedron in the cavity of one before it?
    #[inline(always)]
    pub fn is_killed<H: Held<Tet = T>>(&self, held: &H) -> bool {
        self.tet.is_some_and(|t| self.before(held, t).is_some())
    }

    /// Would it lose an item together with others before it, or is it beside the boundary?
    pub fn waits<H, I>(&self, held: &H, closure: impl Fn() -> I) -> bool
    where
        H: Held<Tet = T>,
        I: Iterator<Item = T>,
    {
        let rival = |t: T| self.rival(held, t);
        // Without candidates of the boundary it does not matter who else is near.
        self.watch.is_some_and(|watch| match held.of_boundary() {
            0 => watch.yields(std::iter::empty(), rival),
            _ => watch.yields(closure(), rival),
        })
    }

    /// Has its closure tetrahedra in the cavities of those before it, if one of the two has to be
    /// alone?
    pub fn is_crowded<H, I>(&self, held: &H, closure: impl Fn() -> I) -> bool
    where
        H: Held<Tet = T>,
        I: Iterator<Item = T>,
    {
        let is_met = |t: T| {
            let before = self.before(held, t);
            before.is_some_and(|other| self.is_alone || held.is_alone(other))
        };
        held.has_alone() && closure().any(is_met)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_double_and_the_last_one_has_all() {
        let (mut waves, mut done) = (vec![0], 0);
        while done < 1000 {
            let wave = next_wave(waves[waves.len() - 1], 1000);
            waves.push(wave);
            done += wave;
        }
        assert_eq!(waves, [0, 1, 2, 4, 8, 16, 32, 64, 1000]);
    }
}
