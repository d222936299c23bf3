//! Vertices have numbers of each submesh's own: no worker's arrays are as long as the point set.

use ltbw::PointSet;
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Config, Correct, Worker};
use ltbw::simulate::{Options, RandomMigrations, simulate};
use ltbw_generate::{PointKind, generate};

#[test]
fn a_worker_has_the_vertices_of_its_part_alone() {
    const WORKERS: u32 = 8;
    let set = PointSet::new(generate(PointKind::Uniform, 20_000, 1)).expect("finite points");
    for ownership in Ownership::ALL {
        let layout = Layout { ownership, ..Layout::new(set.len(), WORKERS) };
        let prepared = layout.distribute(&set).expect("a start");
        let config = Config::new(WORKERS);
        let workers: Vec<_> = prepared
            .workers
            .into_iter()
            .map(|(directory, mesh, points)| {
                Worker::<_, _, Correct>::new(config, directory, mesh, points)
            })
            .collect();
        // Blocks that move bring their vertices along.
        let storm = RandomMigrations { every: 2_000_000 };
        let storm = (ownership == Ownership::Block).then_some(storm);
        let options = Options { storm, ..Options::default() };
        let run = simulate(workers, &options).expect("a run ends");
        for worker in &run.workers {
            let (count, share) = (worker.mesh().num_vertices(), set.len() / WORKERS as usize);
            assert!(count >= share && count < 5 * share / 2, "{ownership:?}: {count} of {share}");
        }
    }
}
