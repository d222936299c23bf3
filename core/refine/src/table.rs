//! Hash tables with one fixed hash function, so that runs repeat exactly; and small keys for them.

pub(crate) use rustc_hash::{FxHashMap as Map, FxHashSet as Set};

/// An edge as a key: its ends, ascending.
pub(crate) fn edge<V: Ord>(a: V, b: V) -> [V; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// A triangle as a key: its corners, ascending.
pub(crate) fn triangle<V: Ord>(a: V, b: V, c: V) -> [V; 3] {
    let [a, b] = edge(a, b);
    let [b, c] = edge(b, c);
    let [a, b] = edge(a, b);
    [a, b, c]
}

/// The edges of a triangle, each with the corner opposite.
pub(crate) fn sides<V: Copy + Ord>([a, b, c]: [V; 3]) -> [([V; 2], V); 3] {
    [(edge(a, b), c), (edge(b, c), a), (edge(a, c), b)]
}
