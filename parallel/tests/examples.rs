//! The examples by task run and end well.

#[path = "../examples/domain.rs"]
#[allow(dead_code, unreachable_pub, reason = "examples are programs")]
mod domain;
#[path = "../examples/points.rs"]
#[allow(dead_code, unreachable_pub, reason = "examples are programs")]
mod points;
#[path = "../examples/threads.rs"]
#[allow(dead_code, unreachable_pub, reason = "examples are programs")]
mod threads;
#[path = "../examples/walk.rs"]
#[allow(dead_code, unreachable_pub, reason = "examples are programs")]
mod walk;
#[path = "../examples/watch.rs"]
#[allow(dead_code, unreachable_pub, reason = "examples are programs")]
mod watch;

#[test]
fn every_example_ends_well() {
    points::main().expect("points");
    walk::main().expect("walk");
    domain::main().expect("domain");
    watch::main().expect("watch");
    threads::main().expect("threads");
}
