//! Our mesh against CGAL's: the same tetrahedra, the same hull, the same hash, or the same refusal.
//! A refined domain against another run's: all that a user sees of it.

use crate::cgal::{Cgal, Failure, Reply};
use ltbw::build::Builder;
use ltbw::refine::Refined;
use ltbw::{BuildError, Mesh, Order, Point, PointSet};

/// Builds `points` in `order` and compares with CGAL; `Err` says what differs.
pub fn compare(cgal: &mut Cgal, points: &[Point], order: Order) -> Result<(), String> {
    let reply = cgal.triangulate(points).map_err(|failure: Failure| failure.to_string())?;
    compare_with(&reply, points, order)
}

/// As [`compare`], with CGAL's reply at hand.
pub fn compare_with(reply: &Reply, points: &[Point], order: Order) -> Result<(), String> {
    let set = PointSet::new(points.to_vec()).map_err(|error| error.to_string())?;
    match Builder::new().order(order).build(&set) {
        Ok(built) => compare_mesh(reply, &built.mesh),
        Err(error) => refusal(reply, &error),
    }
}

/// A mesh, however it was made, against CGAL's reply for its points; `Err` says what differs.
pub fn compare_mesh(reply: &Reply, mesh: &Mesh) -> Result<(), String> {
    if reply.dimension < 3 {
        return Err(format!("we built a mesh, but the dimension is {}", reply.dimension));
    }
    let tets: Vec<[u32; 4]> = mesh.tets().collect();
    let hull: Vec<[u32; 3]> = mesh.hull_facets().collect();
    same("tetrahedra", &tets, &reply.tets)?;
    same("hull facets", &hull, &reply.hull)?;
    let hash = mesh.hash().map_err(|error| error.to_string())?;
    if reply.hash == Some(hash) {
        Ok(())
    } else {
        Err(format!("our hash is {hash}, CGAL's is {:?}", reply.hash))
    }
}

/// Two runs have refined a domain alike, in all that a user sees of it.
///
/// # Panics
/// If they have not; `name` is said.
pub fn same_refined(name: &str, one: &Refined, other: &Refined) {
    let hash = |refined: &Refined| refined.mesh().hash().ok();
    assert_eq!(hash(one), hash(other), "{name}");
    assert_eq!(one.outcome, other.outcome, "{name}");
    // Files are made of these.
    assert!(one.with_exterior() == other.with_exterior(), "{name}: another mesh is written");
    let excuses = |refined: &Refined| -> Vec<_> {
        refined.excuses.iter().map(|e| (refined.tet(e.tet), e.reason)).collect()
    };
    assert!(excuses(one) == excuses(other), "{name}: other excuses");
}

/// Is our refusal the one that CGAL's dimension calls for?
pub fn refusal(reply: &Reply, error: &BuildError) -> Result<(), String> {
    let agrees = match error {
        BuildError::TooFewPoints { .. } => reply.distinct < 4,
        BuildError::Collinear { .. } => reply.dimension == 1,
        BuildError::Coplanar { .. } => reply.dimension == 2,
        _ => false,
    };
    if agrees {
        Ok(())
    } else {
        let (dimension, distinct) = (reply.dimension, reply.distinct);
        Err(format!("we refused ({error}); CGAL: dimension {dimension}, {distinct} points"))
    }
}

/// Simplices as a set: ascending vertices, sorted.
#[must_use]
pub fn canonical<const N: usize>(simplices: &[[u32; N]]) -> Vec<[u32; N]> {
    let mut rows = simplices.to_vec();
    rows.iter_mut().for_each(|row| row.sort_unstable());
    rows.sort_unstable();
    rows
}

fn same<const N: usize>(what: &str, ours: &[[u32; N]], theirs: &[[u32; N]]) -> Result<(), String> {
    let (ours, theirs) = (canonical(ours), canonical(theirs));
    if ours == theirs {
        return Ok(());
    }
    let only = |a: &[[u32; N]], b: &[[u32; N]]| -> Vec<[u32; N]> {
        a.iter().filter(|row| b.binary_search(row).is_err()).take(8).copied().collect()
    };
    Err(format!(
        "{what}: {} of ours, {} of CGAL's; only ours: {:?}, only CGAL's: {:?}",
        ours.len(),
        theirs.len(),
        only(&ours, &theirs),
        only(&theirs, &ours),
    ))
}

#[cfg(test)]
mod tests {
    use super::same;

    #[test]
    fn sets_differ_by_members_not_by_order() {
        assert_eq!(same("x", &[[1, 2], [3, 4]], &[[4, 3], [2, 1]]), Ok(()));
        assert!(same("x", &[[1, 2]], &[[1, 3]]).is_err());
        assert!(same("x", &[[1, 2], [1, 2]], &[[1, 2]]).is_err());
    }
}
