//! The mesh of a domain at the first member, as plain arrays, for files that hold all of it: parts
//! that were numbered, hashed and judged where they are, told one after the other.

use super::Part;
use super::records::{Record, bytes_of, refused, values_of};
use crate::protocol::WorkerId;
use crate::team::{Team, TeamError};
use crate::wire::WireError;
use ltbw_core::{BoundaryFace, TetMesh, Vertex};
use ltbw_exact::Point;
use ltbw_formats::Piece;
use rayon::prelude::*;

/// A mesh whose tetrahedra are in the order of their vertices' numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joined {
    /// All points, by their numbers, and tetrahedra with their regions and triangles.
    pub mesh: TetMesh,
    /// The member whose part each tetrahedron was in.
    pub owners: Vec<u32>,
}

/// Brings the pieces of a mesh to the first member; the others get nothing. Each vertex is one of a
/// piece, or among those `beside` them, which no tetrahedron of a piece has.
///
/// Cost: one sort of all tetrahedra; 32 bytes a point, 24 a tetrahedron and 40 a triangle on the
/// way.
///
/// # Errors
/// [`TeamError`] if a member has failed, or has sent what makes no sense.
pub fn join(
    team: &mut Team,
    piece: &Piece,
    beside: &Part,
    vertices: usize,
) -> Result<Option<Joined>, TeamError> {
    if !team.is_first() {
        let first = WorkerId::default();
        Told::bytes(piece, beside).iter().for_each(|bytes| team.send(first, bytes));
        return Ok(None);
    }
    let mut all = Told { points: vec![[f64::NAN; 3]; vertices], parts: Vec::new() };
    for from in WorkerId::below(team.size()) {
        // One after the other: the first one has the bytes of one part at a time.
        let mut bytes: [Vec<u8>; 4] = match from == team.me() {
            true => Told::bytes(piece, beside),
            false => Default::default(),
        };
        if from != team.me() {
            for own in &mut bytes {
                *own = team.receive(from)?;
            }
        }
        all.add(from, &bytes)?;
    }
    match all.points.iter().position(|point| point[0].is_nan()) {
        Some(k) => Err(refused(team.me(), [k, vertices], "a vertex that nobody has told").into()),
        None => Ok(Some(all.joined())),
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

impl Told {
    /// A member's points, tetrahedra, regions and triangles.
    fn bytes(piece: &Piece, beside: &Part) -> [Vec<u8>; 4] {
        let Piece { mesh, numbers } = piece;
        let number = |v: u32| numbers[v as usize];
        let points = |numbers: &[Vertex], at: &[Point]| {
            let words = |(&v, p): (&Vertex, &Point)| {
                let [x, y, z] = p.map(f64::to_bits);
                [u64::from(v), x, y, z]
            };
            bytes_of(numbers.iter().zip(at).map(words))
        };
        let face = |face: &BoundaryFace| {
            let [a, b, c] = face.corners.map(|v| u64::from(number(v)));
            [a, b, c, face.marker as u64, face.tet as u64]
        };
        let regions = mesh.tet_tags.iter().flatten().map(|&region| region as u64);
        [
            [points(numbers, &mesh.points), points(&beside.numbers, &beside.points)].concat(),
            bytes_of(mesh.tets.iter().map(|tet| tet.map(number))),
            bytes_of(regions.collect::<Vec<u64>>().into_iter()),
            bytes_of(mesh.faces.iter().map(face)),
        ]
    }

    /// Takes in what a member has told.
    fn add(&mut self, from: WorkerId, bytes: &[Vec<u8>; 4]) -> Result<(), WireError> {
        let [points, tets, regions, faces] = bytes;
        let odd =
            |k: usize, of: &[u8], size: usize, what| refused(from, [k * size, of.len()], what);
        let count = self.points.len();
        for (k, [v, x, y, z]) in values_of::<[u64; 4]>(from, points)?.enumerate() {
            let no_point = odd(k, points, <[u64; 4]>::BYTES, "a number of no point");
            let own = usize::try_from(v).ok().and_then(|v| self.points.get_mut(v));
            *own.ok_or(no_point)? = [x, y, z].map(f64::from_bits);
        }
        let own_tets: Vec<[Vertex; 4]> = values_of(from, tets)?.collect();
        if let Some(k) = own_tets.iter().position(|tet| tet.iter().any(|&v| v as usize >= count)) {
            return Err(odd(k, tets, <[Vertex; 4]>::BYTES, "a number of no point"));
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
    fn joined(self) -> Joined {
        let Self { points, parts } = self;
        let of_part = |part: u32| {
            let tets = parts[part as usize].tets.iter().zip(0_u32..);
            tets.map(move |(&tet, place)| (tet, part, place))
        };
        let mut order: Vec<_> = (0..parts.len() as u32).flat_map(of_part).collect();
        order.par_sort_unstable();
        let mut faces: Vec<_> = parts.iter().map(|own| own.faces.iter().peekable()).collect();
        let mut mesh = TetMesh { points, ..TetMesh::default() };
        for (k, &(_, part, place)) in order.iter().enumerate() {
            // The triangles of a tetrahedron stay in their order.
            let (part, place) = (part as usize, place as usize);
            while let Some(face) = faces[part].next_if(|face| face.tet == place) {
                mesh.faces.push(BoundaryFace { tet: k, ..*face });
            }
        }
        let region =
            |&(_, part, place): &(_, u32, u32)| parts[part as usize].regions[place as usize];
        mesh.tet_tags = Some(order.iter().map(region).collect());
        let owners = order.iter().map(|own| own.1).collect();
        mesh.tets = order.into_iter().map(|own| own.0).collect();
        Joined { mesh, owners }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tetrahedra at a triangle, one of them with its outer triangles.
    fn told() -> ([Vec<u8>; 4], [Vec<u8>; 4]) {
        let of = |numbers: [u32; 4], region: i64, tets: &[usize]| {
            let point = |v: &u32| [f64::from(*v), 0.0, 1.0];
            let face = |&tet: &usize| BoundaryFace { corners: [0, 1, 2], marker: -7, tet };
            let mesh = TetMesh {
                points: numbers.iter().map(point).collect(),
                tets: vec![[0, 1, 2, 3]],
                tet_tags: Some(vec![region]),
                faces: tets.iter().map(face).collect(),
                ..TetMesh::default()
            };
            let outside = [5_u32];
            let points = outside.iter().map(point).collect();
            let beside = Part { numbers: outside.to_vec(), points, ..Part::default() };
            Told::bytes(&Piece { mesh, numbers: numbers.to_vec() }, &beside)
        };
        (of([1, 2, 3, 4], 2, &[0, 0]), of([0, 1, 2, 3], 1, &[]))
    }

    fn nothing(vertices: usize) -> Told {
        Told { points: vec![[f64::NAN; 3]; vertices], parts: Vec::new() }
    }

    #[test]
    fn pieces_are_joined_in_the_order_of_numbers() {
        let (a, b) = told();
        let mut all = nothing(6);
        let added = [&a, &b].map(|own| all.add(WorkerId::default(), own));
        assert_eq!(added, [Ok(()), Ok(())]);
        let Joined { mesh, owners } = all.joined();
        assert_eq!(mesh.tets, [[0, 1, 2, 3], [1, 2, 3, 4]]);
        assert_eq!((mesh.tet_tags, owners), (Some(vec![1, 2]), vec![1, 0]));
        assert_eq!(mesh.points, [0, 1, 2, 3, 4, 5].map(|v| [f64::from(v), 0.0, 1.0]));
        assert_eq!(mesh.faces, [BoundaryFace { corners: [1, 2, 3], marker: -7, tet: 1 }; 2]);
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        let (from, (good, _)) = (WorkerId::new(3), told());
        let reason = |vertices: usize, bytes: &[Vec<u8>; 4]| {
            let error = nothing(vertices).add(from, bytes).expect_err("refused");
            (error.from, error.at, error.reason)
        };
        let refused = |at: usize, why: &str| (from, at, why.to_owned());
        assert_eq!(reason(5, &good), refused(4 * 32, "a number of no point"));
        let mut points = good.clone();
        points[0].truncate(3 * 32);
        assert_eq!(reason(4, &points), refused(0, "a number of no point"));
        let mut regions = good.clone();
        regions[2].clear();
        assert_eq!(reason(6, &regions), refused(8, "regions of other tetrahedra"));
        for (at, value) in [(32, 1_u64), (0, 6)] {
            let mut faces = good.clone();
            faces[3][at..at + 8].copy_from_slice(&value.to_le_bytes());
            assert_eq!(reason(6, &faces), refused(0, "a triangle of no tetrahedron"));
        }
        let mut cut = good;
        cut[1].pop();
        assert_eq!(reason(6, &cut), refused(0, "the bytes end within a value"));
    }
}
