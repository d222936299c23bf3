//! A redeal from outside: workers that have stopped between two rounds get other parts of the mesh,
//! and go on. All of them are in this process, or each is in another one of a team: what they tell
//! each other goes through an [`Exchange`].

use super::RoundNode;
use super::figures::Ending;
use super::pace::{Part, cuts};
use super::source::Rounds;
use crate::WorkerError;
use crate::mesh::redeal::{Dealt, Moved};
use crate::mesh::{Blocks, Layout, Redeal};
use crate::protocol::{Config, Directory, Rules, SubmeshError, Worker, WorkerId};
use crate::refining::RefineError;
use crate::refining::domain::DomainMesh;
use crate::threads::RunError;
use ltbw_exact::Point;

/// A value that may go to another process.
#[cfg(feature = "wire")]
pub(super) trait Value: serde::Serialize + serde::de::DeserializeOwned {}
#[cfg(feature = "wire")]
impl<T: serde::Serialize + serde::de::DeserializeOwned> Value for T {}
/// A value that may go to another process.
#[cfg(not(feature = "wire"))]
pub(super) trait Value {}
#[cfg(not(feature = "wire"))]
impl<T> Value for T {}

/// Values for other workers, or from them.
pub(super) type To<T> = Vec<(WorkerId, T)>;

/// The way of values between workers at rest. There is an entry for each worker of this process.
pub(super) trait Exchange {
    /// All get what each has, by worker.
    fn to_all<T: Value>(&mut self, own: Vec<T>) -> Result<Vec<T>, RefineError>;

    /// Each gets what others have for it, with the senders.
    fn to_some<T: Value>(&mut self, own: Vec<To<T>>) -> Result<Vec<To<T>>, RefineError>;
}

/// All workers are in this process.
#[derive(Clone, Copy, Debug)]
pub(super) struct Here;

impl Exchange for Here {
    fn to_all<T: Value>(&mut self, own: Vec<T>) -> Result<Vec<T>, RefineError> {
        Ok(own)
    }

    fn to_some<T: Value>(&mut self, own: Vec<To<T>>) -> Result<Vec<To<T>>, RefineError> {
        let mut all: Vec<To<T>> = own.iter().map(|_| Vec::new()).collect();
        for (from, values) in own.into_iter().enumerate() {
            for (to, value) in values {
                if let Some(all) = all.get_mut(to.index()) {
                    all.push((WorkerId::at(from), value));
                }
            }
        }
        Ok(all)
    }
}

/// The things that workers have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Common<'p> {
    /// The given vertices along the curve.
    pub(super) points: &'p [Point],
    pub(super) layout: Layout,
    pub(super) config: Config,
}

/// A worker that has stopped.
struct Stopped<'c, C> {
    mesh: DomainMesh<'c>,
    source: Rounds<C>,
    directory: Directory,
    moved: Moved,
}

impl<'c, C: Rules> Stopped<'c, C> {
    fn go_on(mut self, config: Config) -> RoundNode<'c, C> {
        self.source.begin_again();
        Worker::new(config, self.directory, self.mesh, self.source)
    }

    fn me(&self) -> WorkerId {
        self.directory.me()
    }

    fn failed(&self, error: SubmeshError) -> RefineError {
        RunError::from(WorkerError::Submesh { worker: self.me(), error }).into()
    }
}

/// Have these workers stopped for a redeal?
pub(super) fn is_due<C: Rules>(nodes: &[RoundNode<'_, C>]) -> bool {
    nodes.first().is_some_and(|node| node.source().ending == Some(Ending::Redeal))
}

/// Workers that have stopped get other parts of the mesh, if that helps, and go on.
///
/// # Errors
/// Those of the exchange, and of a worker to which another one has told what makes no sense.
pub(super) fn redeal<'c, C: Rules>(
    nodes: Vec<RoundNode<'c, C>>,
    common: Common<'_>,
    exchange: &mut impl Exchange,
) -> Result<(Vec<RoundNode<'c, C>>, Vec<Moved>), RefineError> {
    let mut all: Vec<Stopped<'c, C>> = nodes.into_iter().map(stopped).collect();
    let work: Vec<Part> = all.iter().map(|own| own.source.work(&own.mesh)).collect();
    all.iter_mut().zip(&work).for_each(|(own, work)| own.moved.told = work.bytes());
    let parts = exchange.to_all(work)?;
    let Some(first) = all.first() else { return Ok((Vec::new(), Vec::new())) };
    let Layout { workers, redeal, .. } = common.layout;
    let is_forced = matches!(redeal, Redeal::Every(_));
    let blocks = cuts(&parts, first.mesh.inner.blocks(), common.points, is_forced);
    if let Some(blocks) = &blocks {
        move_all(&mut all, blocks, exchange)?;
    }
    let has_moved = blocks.is_some();
    let mut moved = Vec::with_capacity(all.len());
    let config = Config { workers, ..common.config };
    let again = |mut own: Stopped<'c, C>| {
        own.source.have_looked(has_moved);
        own.source.count_moved(own.moved.came);
        moved.push(own.moved);
        own.go_on(config)
    };
    let nodes = all.into_iter().map(again).collect();
    Ok((nodes, moved))
}

/// A worker that has stopped at a border goes on to the next one.
#[cfg(feature = "wire")]
pub(super) fn past_border<'c, C: Rules>(
    node: RoundNode<'c, C>,
    config: Config,
    next: u64,
) -> RoundNode<'c, C> {
    let mut own = stopped(node);
    own.source.border = Some(next);
    own.go_on(config)
}

fn stopped<'c, C: Rules>(node: RoundNode<'c, C>) -> Stopped<'c, C> {
    let (mesh, source, directory) = node.into_parts();
    let moved = Moved { had: mesh.inner.num_tets() as u64, ..Moved::default() };
    Stopped { mesh, source, directory, moved }
}

/// Tetrahedra and items go where they belong by other cuts.
fn move_all<C: Rules>(
    all: &mut [Stopped<'_, C>],
    blocks: &Blocks,
    exchange: &mut impl Exchange,
) -> Result<(), RefineError> {
    let (mut dealt, mut words) = (Vec::new(), Vec::new());
    for own in &mut *all {
        let me = own.me();
        let Stopped { mesh, source, directory, moved } = own;
        let (own_dealt, own_words) = source.recut(mesh, blocks, directory);
        own_words.iter().for_each(|(to, word)| moved.count(me, *to, word.bytes()));
        dealt.push(own_dealt);
        words.push(own_words);
    }
    let heard = exchange.to_some(words)?;
    let mut cargos = Vec::new();
    for ((own, dealt), words) in all.iter_mut().zip(&dealt).zip(heard) {
        let me = own.me();
        let Dealt { leaving, .. } = dealt;
        own.moved.left = leaving.iter().map(|own| own.tets.len() as u64).sum();
        words.iter().for_each(|(from, word)| own.moved.count(me, *from, word.bytes()));
        let cargo = own.source.send_off(&mut own.mesh, dealt, words);
        let cargo = cargo.map_err(|error| own.failed(error))?;
        cargo.iter().for_each(|(to, cargo)| own.moved.count(me, *to, cargo.bytes()));
        cargos.push(cargo);
    }
    let heard = exchange.to_some(cargos)?;
    for (own, cargos) in all.iter_mut().zip(heard) {
        let me = own.me();
        own.moved.came = cargos.iter().map(|(_, cargo)| cargo.tets()).sum();
        cargos.iter().for_each(|(from, cargo)| own.moved.count(me, *from, cargo.bytes()));
        let Stopped { mesh, source, directory, .. } = own;
        source.unpack(mesh, cargos, directory).map_err(|error| own.failed(error))?;
    }
    Ok(())
}
