//! Parts on their way: the reader packs each as bytes and sends it to a thread of its own, which
//! unpacks it, numbers its vertices, and keeps the numbers that they have in the whole.

use crate::Failure;
use crate::step::{Step, of_thread};
use ltbw::TetMesh;
use metis::Idx;
use rustc_hash::FxHashMap;
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

/// The parts that were sent.
pub(crate) struct Dealt {
    pub(crate) bytes: usize,
    /// Vertices of all parts: those between parts count for each.
    pub(crate) copies: usize,
}

/// A part as its thread keeps it.
struct Part {
    points: Vec<[f64; 3]>,
    /// The numbers of its vertices in the whole mesh.
    global: Vec<u32>,
    tets: Vec<[u32; 4]>,
}

/// Sends all parts of a mesh. The processor's time is that of the sender and of all receivers.
pub(crate) fn deal(mesh: &TetMesh, part: &[Idx], parts: usize) -> Result<(Step, Dealt), Failure> {
    let (clock, own) = (Instant::now(), of_thread()?);
    let mut lists: Vec<Vec<usize>> = vec![Vec::new(); parts];
    for (t, &part) in part.iter().enumerate() {
        lists[part as usize].push(t);
    }
    let (mut bytes, mut ways, mut threads) = (0, Vec::new(), Vec::new());
    for _ in 0..parts {
        let (send, receive) = channel::<Vec<u8>>();
        ways.push(send);
        threads.push(std::thread::spawn(move || take(&receive).map_err(|e| e.to_string())));
    }
    for (list, way) in lists.iter().zip(ways) {
        let letter = packed(mesh, list);
        bytes += letter.len();
        way.send(letter)?;
    }
    let (mut copies, mut all, mut others) = (0, 0, 0.0);
    for thread in threads {
        let (part, seconds) = thread.join().map_err(|_| "a thread has panicked")??;
        copies += part.global.len();
        all += part.tets.len();
        others += seconds;
        std::hint::black_box(part.points);
    }
    if all != mesh.tets.len() {
        return Err("tetrahedra were lost on their way".into());
    }
    let processor = of_thread()? - own + others;
    Ok((Step { clock: clock.elapsed().as_secs_f64(), processor }, Dealt { bytes, copies }))
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

/// A part as it arrives, and the seconds that this thread has taken for it.
fn take(way: &Receiver<Vec<u8>>) -> Result<(Part, f64), Failure> {
    let letter = way.recv()?;
    let begin = of_thread()?;
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
    Ok((part, of_thread()? - begin))
}
