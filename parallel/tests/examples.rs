//! The examples by task run and end well, and stay as short as a first program should be.

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

/// Lines of a program that are neither empty nor comments.
fn lines(program: &str) -> usize {
    let lines = program.lines().map(str::trim);
    lines.filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// The `use` lines of a program.
fn uses(program: &str) -> Vec<&str> {
    program.lines().map(str::trim).filter(|line| line.starts_with("use ")).collect()
}

#[test]
fn first_programs_are_short_and_need_the_prelude_alone() {
    let walk = include_str!("../examples/walk.rs");
    let watch = include_str!("../examples/watch.rs");
    let threads = include_str!("../examples/threads.rs");
    for (name, program, most) in
        [("walk", walk, 12), ("watch", watch, 20), ("threads", threads, 10)]
    {
        let count = lines(program);
        assert!((5..=most).contains(&count), "{name}: {count} lines, not {most}");
        assert_eq!(uses(program), ["use ltbw::prelude::*;"], "{name}");
        assert_eq!(program.matches("ltbw::").count(), 1, "{name} names a path");
    }
    let watched = ["holes:", "sizing(", "observer(", "cancel("];
    assert!(watched.iter().all(|part| watch.contains(part)));
    assert!(threads.contains("threads(2)") && threads.contains("summary"));
}
