//! Circles of boundary items that wait for each other.

/// The circles among items in the order of their places, each from its foremost item on, in the
/// order of these. Items are told by their numbers in that order; `first` tells for each the one
/// that goes before it.
pub(crate) fn circles(first: &[Option<usize>]) -> Vec<Vec<usize>> {
    let mut seen: Vec<Option<usize>> = vec![None; first.len()];
    let mut all: Vec<Vec<usize>> = Vec::new();
    for start in 0..first.len() {
        let mut at = Some(start);
        // A way goes on to items not seen before, of which there are finitely many.
        while let Some(k) = at.filter(|&k| seen[k].is_none()) {
            seen[k] = Some(start);
            at = first[k];
        }
        let Some(end) = at.filter(|&k| seen[k] == Some(start)) else { continue };
        let (mut circle, mut next) = (vec![end], first[end]);
        while let Some(k) = next.filter(|&k| k != end) {
            circle.push(k);
            next = first[k];
        }
        let least = circle.iter().enumerate().min_by_key(|own| own.1).map_or(0, |own| own.0);
        circle.rotate_left(least);
        all.push(circle);
    }
    all.sort_unstable_by_key(|circle| circle[0]);
    all
}

#[cfg(test)]
mod tests {
    use super::circles;

    #[test]
    fn each_circle_is_found_once_and_begins_with_its_foremost() {
        // 5 -> 3 -> 1 -> 5, entered by 0 and 2; 4 waits for itself; 6 for nobody, 7 for 6.
        let first = [Some(3), Some(5), Some(0), Some(1), Some(4), Some(3), None, Some(6)];
        assert_eq!(circles(&first), [vec![1, 5, 3], vec![4]]);
        assert!(circles(&[]).is_empty() && circles(&[None, Some(0)]).is_empty());
        // One long circle, by steps of three.
        let first: Vec<Option<usize>> = (0..100).map(|k| Some((k + 3) % 100)).collect();
        let all = circles(&first);
        assert_eq!((all.len(), all[0].len(), all[0][0]), (1, 100, 0));
    }
}
