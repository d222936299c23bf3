//! Parts on their way: the first process packs each as bytes and sends it to the process of its
//! number, round by round; that unpacks it, numbers its vertices, and keeps the numbers that they
//! have in the whole.

use crate::Failure;
use ltbw::TetMesh;
use metis::Idx;
use mpi::collective::SystemOperation;
use mpi::point_to_point::{Destination, Source};
use mpi::topology::{Communicator, SimpleCommunicator};
use mpi::traits::Root;
use rustc_hash::FxHashMap;

/// A mesh with the part of each of its tetrahedra.
pub(crate) struct Whole<'a> {
    pub(crate) mesh: &'a TetMesh,
    pub(crate) part: &'a [Idx],
}

/// The parts that were sent; sums are the first process's.
#[derive(Default)]
pub(crate) struct Dealt {
    pub(crate) bytes: usize,
    /// Vertices of all parts: those between parts count for each.
    pub(crate) copies: usize,
    pub(crate) tets: usize,
}

/// A part as its process keeps it.
struct Part {
    points: Vec<[f64; 3]>,
    /// The numbers of its vertices in the whole mesh.
    global: Vec<u32>,
    tets: Vec<[u32; 4]>,
}

/// Sends all parts of a mesh, which the first process has; ends when all have theirs. Every
/// process of the job has to call this.
pub(crate) fn deal(
    world: &SimpleCommunicator,
    whole: Option<&Whole>,
    parts: usize,
) -> Result<Dealt, Failure> {
    let (rank, size) = (usize::try_from(world.rank())?, usize::try_from(world.size())?);
    let mut own = Dealt::default();
    let mut keep = |letter: &[u8]| -> Result<Part, Failure> {
        let part = taken(letter)?;
        own.bytes += letter.len();
        own.copies += part.global.len();
        own.tets += part.tets.len();
        Ok(part)
    };
    let mut kept = Vec::new();
    match whole {
        Some(whole) => {
            for (k, list) in lists(whole, parts).iter().enumerate() {
                let letter = packed(whole.mesh, list);
                match k % size {
                    0 => kept.push(keep(&letter)?),
                    to => world.process_at_rank(i32::try_from(to)?).send(&letter[..]),
                }
            }
        }
        None => {
            for _ in (rank..parts).step_by(size) {
                let (letter, _) = world.process_at_rank(0).receive_vec::<u8>();
                kept.push(keep(&letter)?);
            }
        }
    }
    std::hint::black_box(kept.iter().map(|part| part.points.len()).sum::<usize>());
    let here = [own.bytes as u64, own.copies as u64, own.tets as u64];
    let mut sums = [0u64; 3];
    let root = world.process_at_rank(0);
    if rank == 0 {
        root.reduce_into_root(&here[..], &mut sums[..], SystemOperation::sum());
    } else {
        root.reduce_into(&here[..], SystemOperation::sum());
    }
    let [bytes, copies, tets] = sums.map(|sum| sum as usize);
    Ok(Dealt { bytes, copies, tets })
}

/// The tetrahedra of each part.
fn lists(whole: &Whole, parts: usize) -> Vec<Vec<usize>> {
    let mut lists: Vec<Vec<usize>> = vec![Vec::new(); parts];
    for (t, &part) in whole.part.iter().enumerate() {
        lists[part as usize].push(t);
    }
    lists
}

/// A letter with a part: for each tetrahedron the numbers of its corners and where they are, each
/// vertex once.
fn packed(mesh: &TetMesh, list: &[usize]) -> Vec<u8> {
    let mut vertices: Vec<u32> = list.iter().flat_map(|&t| mesh.tets[t]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut letter = Vec::with_capacity(8 + 28 * vertices.len() + 16 * list.len());
    letter.extend((vertices.len() as u64).to_le_bytes());
    for &v in &vertices {
        letter.extend(v.to_le_bytes());
        for x in mesh.points[v as usize] {
            letter.extend(x.to_le_bytes());
        }
    }
    for &t in list {
        for v in mesh.tets[t] {
            letter.extend(v.to_le_bytes());
        }
    }
    letter
}

/// The part of a letter.
fn taken(letter: &[u8]) -> Result<Part, Failure> {
    let (count, rest) = letter.split_first_chunk::<8>().ok_or("an empty letter")?;
    let count = usize::try_from(u64::from_le_bytes(*count))?;
    let (vertices, corners) = rest.split_at_checked(28 * count).ok_or("a short letter")?;
    let number = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let mut numbers: FxHashMap<u32, u32> = FxHashMap::default();
    numbers.reserve(count);
    let mut part = Part { points: Vec::new(), global: Vec::new(), tets: Vec::new() };
    for row in vertices.chunks_exact(28) {
        let (global, place) = (number(row), u32::try_from(part.global.len())?);
        let mut at = [0.0; 3];
        for (x, bytes) in at.iter_mut().zip(row[4..].as_chunks::<8>().0) {
            *x = f64::from_le_bytes(*bytes);
        }
        numbers.insert(global, place);
        part.global.push(global);
        part.points.push(at);
    }
    for row in corners.chunks_exact(16) {
        let mut tet = [0; 4];
        for (corner, bytes) in tet.iter_mut().zip(row.chunks_exact(4)) {
            *corner = *numbers.get(&number(bytes)).ok_or("a corner that was not sent")?;
        }
        part.tets.push(tet);
    }
    Ok(part)
}
