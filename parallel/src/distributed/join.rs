//! The mesh of a domain at the first member, as plain arrays, for files that hold all of it: parts
//! that were numbered, hashed and judged where they are, told one after the other.

use super::Part;
use super::records::{Record, bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use crate::wire::WireError;
use ltbw_core::{BoundaryFace, TetMesh, Vertex};
use ltbw_exact::Point;
use ltbw_exact::points::MAX_POINTS;
use ltbw_formats::Piece;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

/// A mesh whose tetrahedra are in the order of their vertices' numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joined {
    /// All points, by their numbers, and tetrahedra with their regions and triangles.
    pub mesh: TetMesh,
    /// The member whose part each tetrahedron was in.
    pub owners: Vec<u32>,
}

/// Brings the pieces of a mesh to the first member; the others get nothing. Each vertex is one of a
/// piece, or among those that tetrahedra `beside` them have.
///
/// Cost: 32 bytes a point, 24 a tetrahedron and 40 a triangle on the way; at the first one lists of
/// all parts, which are merged.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn join(
    team: &mut Team,
    piece: Piece,
    beside: Part,
    vertices: u64,
) -> Result<Option<Joined>, TeamError> {
    if !team.is_first() {
        let bytes = told(&piece, &beside);
        drop((piece, beside));
        bytes.iter().for_each(|bytes| team.send(WorkerId::default(), bytes));
        return Ok(None);
    }
    let me = team.me();
    let length = usize::try_from(vertices).unwrap_or(usize::MAX);
    if length > MAX_POINTS {
        return Err(refused(me, [0, length], "more vertices than there are numbers").into());
    }
    let mut all = Told { points: vec![[f64::NAN; 3]; length], parts: Vec::new() };
    all.add(me, &told(&piece, &beside))?;
    drop((piece, beside));
    for from in WorkerId::below(team.size()).skip(1) {
        let mut bytes = [const { Vec::new() }; 4];
        for own in &mut bytes {
            *own = team.receive(from)?;
        }
        all.add(from, &bytes)?;
    }
    match all.points.iter().position(is_untold) {
        Some(k) => Err(refused(me, [k, length], "a vertex that nobody has told").into()),
        None => Ok(Some(all.joined()?)),
    }
}

/// The pieces that the first member was told.
struct Told {
    /// By number; no number where nobody has told one yet.
    points: Vec<Point>,
    parts: Vec<ToldPart>,
}

/// Tetrahedra of one piece, by numbers, with their regions, and triangles with their places in it.
struct ToldPart {
    tets: Vec<[Vertex; 4]>,
    regions: Vec<i64>,
    faces: Vec<BoundaryFace>,
}

fn is_untold(point: &Point) -> bool {
    point[0].is_nan()
}

/// A member's points, tetrahedra, regions and triangles.
fn told(piece: &Piece, beside: &Part) -> [Vec<u8>; 4] {
    let Piece { mesh, numbers } = piece;
    let number = |v: u32| numbers[v as usize];
    let point = |(&v, p): (&Vertex, &Point)| {
        let [x, y, z] = p.map(f64::to_bits);
        [u64::from(v), x, y, z]
    };
    let mut points = bytes_of(numbers.iter().zip(&mesh.points).map(point));
    points.extend(bytes_of(beside.numbers.iter().zip(&beside.points).map(point)));
    let face = |face: &BoundaryFace| {
        let [a, b, c] = face.corners.map(|v| u64::from(number(v)));
        [a, b, c, face.marker as u64, face.tet as u64]
    };
    let regions = mesh.tet_tags.as_deref().unwrap_or_default();
    [
        points,
        bytes_of(mesh.tets.iter().map(|tet| tet.map(number))),
        bytes_of(regions.iter().map(|&region| region as u64)),
        bytes_of(mesh.faces.iter().map(face)),
    ]
}

impl Told {
    /// Takes in what a member has told.
    fn add(&mut self, from: WorkerId, bytes: &[Vec<u8>; 4]) -> Result<(), WireError> {
        let [points, tets, regions, faces] = bytes;
        let odd =
            |k: usize, of: &[u8], size: usize, what| refused(from, [k * size, of.len()], what);
        let count = self.points.len();
        for (k, [v, x, y, z]) in values_of::<[u64; 4]>(from, points)?.enumerate() {
            let odd = |what| odd(k, points, <[u64; 4]>::BYTES, what);
            let own = usize::try_from(v).ok().and_then(|v| self.points.get_mut(v));
            let (own, point) =
                (own.ok_or_else(|| odd("a number of no point"))?, [x, y, z].map(f64::from_bits));
            if point.iter().any(|c| !c.is_finite()) {
                return Err(odd("a coordinate that is not finite"));
            }
            if !is_untold(own) && own.map(f64::to_bits) != [x, y, z] {
                return Err(odd("another place than others have told"));
            }
            *own = point;
        }
        let own_tets: Vec<[Vertex; 4]> = values_of(from, tets)?.collect();
        let is_odd = |tet: &[Vertex; 4]| tet.iter().any(|&v| v as usize >= count);
        let falls = || own_tets.windows(2).position(|pair| pair[0] >= pair[1]);
        for (k, what) in [
            (own_tets.iter().position(is_odd), "a number of no point"),
            (falls(), "tetrahedra that are not in order"),
        ] {
            if let Some(k) = k {
                return Err(odd(k, tets, <[Vertex; 4]>::BYTES, what));
            }
        }
        let own_regions: Vec<i64> =
            values_of::<u64>(from, regions)?.map(|region| region as i64).collect();
        if own_regions.len() != own_tets.len() {
            return Err(odd(own_tets.len(), regions, u64::BYTES, "regions of other tetrahedra"));
        }
        let mut own_faces: Vec<BoundaryFace> = Vec::new();
        for (k, [a, b, c, marker, tet]) in values_of::<[u64; 5]>(from, faces)?.enumerate() {
            let is_point = [a, b, c].iter().all(|&v| v < count as u64);
            let before = own_faces.last().map_or(0, |face| face.tet as u64);
            if !is_point || tet < before || tet >= own_tets.len() as u64 {
                return Err(odd(k, faces, <[u64; 5]>::BYTES, "a triangle of no tetrahedron"));
            }
            let corners = [a, b, c].map(|v| v as u32);
            own_faces.push(BoundaryFace { corners, marker: marker as i64, tet: tet as usize });
        }
        self.parts.push(ToldPart { tets: own_tets, regions: own_regions, faces: own_faces });
        Ok(())
    }

    /// The mesh.
    ///
    /// # Errors
    /// [`WireError`] if two members have told of one tetrahedron.
    fn joined(self) -> Result<Joined, WireError> {
        let Self { points, parts } = self;
        let count = parts.iter().map(|own| own.tets.len()).sum();
        let (mut tets, mut regions) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut owners, mut faces) = (Vec::with_capacity(count), Vec::new());
        let mut triangles: Vec<_> = parts.iter().map(|own| own.faces.iter().peekable()).collect();
        let mut places = vec![0; parts.len()];
        let first = |part: usize| Some(Reverse((*parts[part].tets.first()?, part)));
        let mut heads: BinaryHeap<_> = (0..parts.len()).filter_map(first).collect();
        while let Some(mut head) = heads.peek_mut() {
            let (tet, part) = head.0;
            let (own, place) = (&parts[part], places[part]);
            if tets.last() == Some(&tet) {
                let ends = [place, own.tets.len()].map(|k| k * <[Vertex; 4]>::BYTES);
                let from = WorkerId::new(part as u32);
                return Err(refused(from, ends, "a tetrahedron that another one has told"));
            }
            // The triangles of a tetrahedron stay in their order.
            while let Some(face) = triangles[part].next_if(|face| face.tet == place) {
                faces.push(BoundaryFace { tet: tets.len(), ..*face });
            }
            tets.push(tet);
            regions.push(own.regions[place]);
            owners.push(part as u32);
            places[part] = place + 1;
            match own.tets.get(place + 1) {
                Some(&next) => head.0.0 = next,
                None => drop(PeekMut::pop(head)),
            }
        }
        let mesh = TetMesh { points, tets, tet_tags: Some(regions), faces, ..TetMesh::default() };
        Ok(Joined { mesh, owners })
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;
    use crate::team::threads;

    /// A tetrahedron of a mesh by numbers, with its outer triangles, and a vertex beside it.
    fn part(numbers: [u32; 4], region: i64, faces: usize) -> (Piece, Part) {
        let point = |v: &u32| [f64::from(*v), 0.0, 1.0];
        let face = BoundaryFace { corners: [0, 1, 2], marker: -7, tet: 0 };
        let mesh = TetMesh {
            points: numbers.iter().map(point).collect(),
            tets: vec![[0, 1, 2, 3]],
            tet_tags: Some(vec![region]),
            faces: vec![face; faces],
            ..TetMesh::default()
        };
        let beside = Part { numbers: vec![5], points: vec![point(&5)], ..Part::default() };
        (Piece { mesh, numbers: numbers.to_vec() }, beside)
    }

    /// The words of the team whose members have these parts.
    fn joined(parts: Vec<(Piece, Part)>, vertices: u64) -> Vec<Result<Option<Joined>, TeamError>> {
        let posts = threads(parts.len() as u32);
        std::thread::scope(|scope| {
            let run = |(post, (piece, beside))| {
                scope.spawn(move || join(&mut Team::new(post), piece, beside, vertices))
            };
            let all: Vec<_> = posts.into_iter().zip(parts).map(run).collect();
            all.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        })
    }

    #[test]
    fn pieces_are_joined_in_the_order_of_numbers() {
        let parts = vec![part([1, 2, 3, 4], 2, 2), part([0, 1, 2, 3], 1, 0)];
        let mut all = joined(parts, 6);
        assert_eq!(all.pop(), Some(Ok(None)), "the first one has the mesh");
        let Some(Ok(Some(Joined { mesh, owners }))) = all.pop() else { panic!("a mesh") };
        assert_eq!(mesh.tets, [[0, 1, 2, 3], [1, 2, 3, 4]]);
        assert_eq!((mesh.tet_tags, owners), (Some(vec![1, 2]), vec![1, 0]));
        assert_eq!(mesh.points, [0, 1, 2, 3, 4, 5].map(|v| [f64::from(v), 0.0, 1.0]));
        assert_eq!(mesh.faces, [BoundaryFace { corners: [1, 2, 3], marker: -7, tet: 1 }; 2]);
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        let from = WorkerId::new(3);
        let (piece, beside) = part([1, 2, 3, 4], 2, 2);
        let good = told(&piece, &beside);
        let reason = |vertices: usize, bytes: &[Vec<u8>; 4]| {
            let mut all = Told { points: vec![[f64::NAN; 3]; vertices], parts: Vec::new() };
            all.points[1..2].fill([1.0, 0.0, 1.0]);
            let error = all.add(from, bytes).expect_err("refused");
            (error.from, error.at, error.reason)
        };
        let refused = |at: usize, why: &str| (from, at, why.to_owned());
        let with = |list: usize, at: usize, value: u64| {
            let mut bytes = good.clone();
            bytes[list][at..at + 8].copy_from_slice(&value.to_le_bytes());
            bytes
        };
        assert_eq!(reason(5, &good), refused(4 * 32, "a number of no point"));
        let no_number = with(0, 32 + 16, f64::INFINITY.to_bits());
        assert_eq!(reason(6, &no_number), refused(32, "a coordinate that is not finite"));
        let moved = with(0, 8, 2_f64.to_bits());
        assert_eq!(reason(6, &moved), refused(0, "another place than others have told"));
        assert_eq!(reason(6, &with(1, 0, u64::MAX)), refused(0, "a number of no point"));
        let mut twice = good.clone();
        twice[1].extend_from_within(..);
        assert_eq!(reason(6, &twice), refused(0, "tetrahedra that are not in order"));
        let mut regions = good.clone();
        regions[2].clear();
        assert_eq!(reason(6, &regions), refused(8, "regions of other tetrahedra"));
        for (at, value) in [(32, 1_u64), (0, 6)] {
            let odd = with(3, at, value);
            assert_eq!(reason(6, &odd), refused(0, "a triangle of no tetrahedron"));
        }
        let mut cut = good;
        cut[1].pop();
        assert_eq!(reason(6, &cut), refused(0, "the bytes end within a value"));
    }

    #[test]
    fn vertices_that_nobody_has_told_are_an_error() {
        for (vertices, why) in [(7, "nobody has told"), (u64::MAX, "than there are numbers")] {
            let mut all =
                joined(vec![part([0, 1, 2, 3], 1, 0), part([1, 2, 3, 4], 2, 0)], vertices);
            let error = all.swap_remove(0).expect_err("no mesh").to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
