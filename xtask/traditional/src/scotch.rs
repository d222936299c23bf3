//! PT-Scotch's partition of the graph of tetrahedra, by all processes of a job: the only unsafe
//! code of this crate. Its functions are C's, with numbers of 32 bits, as Debian builds them.

use crate::Failure;
use crate::graph::Dual;
use metis::Idx;
use mpi::datatype::PartitionMut;
use mpi::point_to_point::{Destination, Source};
use mpi::raw::AsRaw;
use mpi::topology::{Communicator, SimpleCommunicator};
use mpi::traits::Root;
use std::os::raw::{c_int, c_void};
use std::ptr::null_mut;

/// Objects of the library, whose inside is its own.
type Object = *mut c_void;

#[link(name = "ptscotch")]
#[link(name = "scotch")]
#[link(name = "ptscotcherr")]
unsafe extern "C" {
    fn SCOTCH_numSizeof() -> c_int;
    fn SCOTCH_dgraphAlloc() -> Object;
    fn SCOTCH_dgraphInit(graph: Object, comm: mpi::ffi::MPI_Comm) -> c_int;
    fn SCOTCH_dgraphBuild(
        graph: Object,
        base: Idx,
        vertices: Idx,
        most: Idx,
        starts: *mut Idx,
        ends: *mut Idx,
        loads: *mut Idx,
        labels: *mut Idx,
        arcs: Idx,
        room: Idx,
        others: *mut Idx,
        ghosts: *mut Idx,
        weights: *mut Idx,
    ) -> c_int;
    fn SCOTCH_dgraphPart(graph: Object, parts: Idx, strategy: Object, part: *mut Idx) -> c_int;
    fn SCOTCH_dgraphExit(graph: Object);
    fn SCOTCH_stratAlloc() -> Object;
    fn SCOTCH_stratInit(strategy: Object) -> c_int;
    fn SCOTCH_stratExit(strategy: Object);
    fn SCOTCH_memFree(object: Object);
}

/// Says what has failed, if a call of the library has.
fn is_done(code: c_int, what: &str) -> Result<(), Failure> {
    if code == 0 { Ok(()) } else { Err(format!("PT-Scotch: {what} has failed: {code}").into()) }
}

/// An object of the library, and what ends it.
struct Owned {
    object: Object,
    exit: unsafe extern "C" fn(Object),
}

impl Owned {
    /// An object that `start` begins and `exit` ends.
    fn new(
        object: Object,
        start: impl FnOnce(Object) -> c_int,
        exit: unsafe extern "C" fn(Object),
    ) -> Result<Self, Failure> {
        if object.is_null() {
            return Err("PT-Scotch: out of memory".into());
        }
        let begun = is_done(start(object), "beginning an object");
        if begun.is_err() {
            // SAFETY: the object was not begun, and nobody else has it.
            unsafe { SCOTCH_memFree(object) };
        }
        begun.map(|()| Self { object, exit })
    }
}

impl Drop for Owned {
    fn drop(&mut self) {
        // SAFETY: the object was begun, is ended by its own function, once, and freed after that.
        unsafe {
            (self.exit)(self.object);
            SCOTCH_memFree(self.object);
        }
    }
}

/// The rows of a stretch of the graph's vertices, which begin at 0; their ends are the next ones'
/// starts.
struct Stretch {
    starts: Vec<Idx>,
    others: Vec<Idx>,
}

/// The parts of all tetrahedra, at the first process, which alone has the graph; the others get
/// none. Every process of the job has to call this.
pub(crate) fn part(
    world: &SimpleCommunicator,
    whole: Option<&Dual>,
    parts: usize,
) -> Result<Vec<Idx>, Failure> {
    // SAFETY: the call only tells a size.
    if unsafe { SCOTCH_numSizeof() } as usize != size_of::<Idx>() {
        return Err("PT-Scotch is built with numbers of another size than METIS".into());
    }
    let Stretch { mut starts, mut others } = scattered(world, whole)?;
    let (here, arcs) = (Idx::try_from(starts.len() - 1)?, Idx::try_from(others.len())?);
    // SAFETY: the communicator outlives the graph, which the calls begin as their manual says.
    let graph = unsafe {
        let begin = |graph| SCOTCH_dgraphInit(graph, world.as_raw());
        Owned::new(SCOTCH_dgraphAlloc(), begin, SCOTCH_dgraphExit)?
    };
    let (first, none) = (starts.as_mut_ptr(), null_mut());
    // SAFETY: the rows are complete and outlive the graph, which is declared after them; null
    // stands for loads, labels and weights of one, and for room that the library takes itself.
    let code = unsafe {
        let (ends, to) = (first.add(1), others.as_mut_ptr());
        let object = graph.object;
        SCOTCH_dgraphBuild(
            object, 0, here, here, first, ends, none, none, arcs, arcs, to, none, none,
        )
    };
    is_done(code, "building a graph")?;
    // SAFETY: as that of the graph.
    let strategy =
        unsafe { Owned::new(SCOTCH_stratAlloc(), |own| SCOTCH_stratInit(own), SCOTCH_stratExit)? };
    let mut own: Vec<Idx> = vec![0; starts.len() - 1];
    let count = Idx::try_from(parts)?;
    // SAFETY: `own` has a place for each vertex of the graph that is here.
    let code = unsafe { SCOTCH_dgraphPart(graph.object, count, strategy.object, own.as_mut_ptr()) };
    is_done(code, "partitioning")?;
    gathered(world, &own, whole)
}

/// Gives each process its stretch of the first one's graph.
fn scattered(world: &SimpleCommunicator, whole: Option<&Dual>) -> Result<Stretch, Failure> {
    let Some(dual) = whole else {
        let first = world.process_at_rank(0);
        let (starts, _) = first.receive_vec::<Idx>();
        let (others, _) = first.receive_vec::<Idx>();
        return Ok(Stretch { starts, others });
    };
    let size = usize::try_from(world.size())?;
    let bound = |rank: usize| dual.len() * rank / size;
    let stretch = |rank: usize| {
        let rows = &dual.starts()[bound(rank)..=bound(rank + 1)];
        let (from, to) = (rows[0] as usize, rows[rows.len() - 1] as usize);
        let starts = rows.iter().map(|start| start - rows[0]).collect();
        Stretch { starts, others: dual.others()[from..to].to_vec() }
    };
    for rank in 1..size {
        let (to, own) = (world.process_at_rank(i32::try_from(rank)?), stretch(rank));
        to.send(&own.starts[..]);
        to.send(&own.others[..]);
    }
    Ok(stretch(0))
}

/// The parts of all at the first process: stretches lie in the order of processes.
fn gathered(
    world: &SimpleCommunicator,
    own: &[Idx],
    whole: Option<&Dual>,
) -> Result<Vec<Idx>, Failure> {
    let (root, count) = (world.process_at_rank(0), c_int::try_from(own.len())?);
    let Some(dual) = whole else {
        root.gather_into(&count);
        root.gather_varcount_into(own);
        return Ok(Vec::new());
    };
    let mut counts: Vec<c_int> = vec![0; usize::try_from(world.size())?];
    root.gather_into_root(&count, &mut counts[..]);
    let offset = |sum: &mut c_int, count: &c_int| {
        let start = *sum;
        *sum += count;
        Some(start)
    };
    let starts: Vec<c_int> = counts.iter().scan(0, offset).collect();
    let mut all: Vec<Idx> = vec![0; dual.len()];
    root.gather_varcount_into_root(own, &mut PartitionMut::new(&mut all[..], counts, starts));
    Ok(all)
}
