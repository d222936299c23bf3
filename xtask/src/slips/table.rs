//! The slips: 22 that a reader planted in one day, of every part of the code. The first suites
//! missed five of them; the tests named here see each.

/// A slip.
pub(super) struct Slip {
    pub(super) number: u32,
    pub(super) what: &'static str,
    pub(super) edits: &'static [Edit],
    /// The test that sees it, and the file that has it.
    pub(super) test: &'static str,
    pub(super) at: &'static str,
    /// It changes no verdict: the test passes.
    pub(super) is_equivalent: bool,
}

/// A change: text that a file has once, and what stands there in its place. Both are expressions,
/// or statements in the place of statements.
pub(super) struct Edit {
    pub(super) file: &'static str,
    pub(super) right: &'static str,
    pub(super) wrong: &'static str,
}

/// The packages with slips, and their folders.
pub(super) const PACKAGES: &[(&str, &str)] = &[
    ("ltbw-core", "core/kernel"),
    ("ltbw-domain", "core/domain"),
    ("ltbw-refine", "core/refine"),
    ("ltbw-formats", "core/formats"),
    ("ltbw", "parallel"),
    ("ltbw-verify", "verify/checker"),
    ("ltbw-cli", "cli"),
];

/// A slip that a test sees.
const fn seen(
    number: u32,
    what: &'static str,
    edits: &'static [Edit],
    test: &'static str,
    at: &'static str,
) -> Slip {
    Slip { number, what, edits, test, at, is_equivalent: false }
}

pub(super) const SLIPS: &[Slip] = &[
    seen(
        1,
        "the new tetrahedron is asked whether it is beside another worker's, not its neighbour",
        &[Edit {
            file: "parallel/src/refining/rounds/keys.rs",
            right: "self.is_beside(n)",
            wrong: "self.is_beside(t)",
        }],
        "exchanges_tell_what_stands_beyond_every_interface_face",
        "parallel/src/refining/rounds/keys/tests.rs",
    ),
    seen(
        2,
        "tetrahedra join a boundary round at < instead of <=",
        &[Edit {
            file: "core/refine/src/rounds/choose.rs",
            right: "items * BESIDE <= counted",
            wrong: "items * BESIDE < counted",
        }],
        "tetrahedra_join_boundary_items_from_the_exact_number_on",
        "core/refine/src/rounds/choose.rs",
    ),
    seen(
        3,
        "the budget is one point too small",
        &[Edit {
            file: "parallel/src/refining/rounds/stages.rs",
            right: "self.budget.total + sums[CANDIDATES] > self.budget.most",
            wrong: "self.budget.total + sums[CANDIDATES] >= self.budget.most",
        }],
        "a_budget_is_used_up_to_the_last_point",
        "parallel/src/refining/rounds/stages/tests.rs",
    ),
    seen(
        4,
        "a cavity found ahead is kept though its ring has changed",
        &[Edit {
            file: "core/refine/src/rounds/keys.rs",
            right: "stands(t) && mesh.neighbours(t).into_iter().all(stands)",
            wrong: "stands(t)",
        }],
        "a_cavity_has_changed_if_its_ring_has",
        "parallel/src/refining/rounds/keys/tests.rs",
    ),
    seen(
        5,
        "of two limits for one item the later holds",
        &[Edit {
            file: "parallel/src/refining/rounds/demands.rs",
            right: "Some(a.or(b))",
            wrong: "Some(b)",
        }],
        "of_several_limits_for_one_item_the_smallest_holds",
        "parallel/src/refining/rounds/stages/tests.rs",
    ),
    seen(
        6,
        "whether a rival is apart is read from the wrong bit",
        &[Edit {
            file: "parallel/src/refining/news.rs",
            right: "byte & 4 != 0",
            wrong: "byte & 2 != 0",
        }],
        "rivals_come_as_they_are_sent",
        "parallel/src/refining/news.rs",
    ),
    seen(
        7,
        "the old rank of a far slot is not forgotten",
        &[Edit {
            file: "parallel/src/refining/rounds/keys.rs",
            right: "self.own.forget(far)",
            wrong: "",
        }],
        "exchanges_tell_what_stands_beyond_every_interface_face",
        "parallel/src/refining/rounds/keys/tests.rs",
    ),
    seen(
        8,
        "a boundary item marks only slots that nobody held",
        &[Edit {
            file: "parallel/src/refining/rounds/reserved.rs",
            right: "self.by_boundary.set(t.index(), true)",
            wrong: "if other.is_none() { self.by_boundary.set(t.index(), true) }",
        }],
        "boundary_items_are_known_wherever_they_hold",
        "parallel/src/refining/rounds/reserved.rs",
    ),
    seen(
        9,
        "a ring tetrahedron gets the block of the own worker, not of its own",
        &[Edit {
            file: "parallel/src/mesh/fill.rs",
            right: "fixed.block_of(worker)",
            wrong: "fixed.block_of(self.me)",
        }],
        "",
        "parallel/tests/closure.rs",
    ),
    seen(
        10,
        "a ring tetrahedron that has a name gets a second one",
        &[Edit {
            file: "parallel/src/mesh/fill.rs",
            right: "boundary[k].ring_name.is_none()",
            wrong: "true",
        }],
        "",
        "parallel/tests/closure.rs",
    ),
    seen(
        11,
        "a point too many is left in the count after a move",
        &[Edit {
            file: "parallel/src/mesh/point_queue.rs",
            right: "self.left -= taken.len()",
            wrong: "self.left -= taken.len().saturating_sub(1)",
        }],
        "a_block_moves_with_its_points",
        "parallel/src/mesh/point_queue/tests.rs",
    ),
    seen(
        12,
        "a change of a witness is not looked at",
        &[Edit {
            file: "core/refine/src/rounds/keys.rs",
            right: "changed(own, other) | is_alone",
            wrong: "is_alone",
        }],
        "a_witness_holds_until_something_on_the_way_there_changes",
        "core/refine/src/rounds/keys.rs",
    ),
    seen(
        13,
        "cached spheres are asked of points up to four frames away",
        &[Edit {
            file: "core/kernel/src/sphere.rs",
            right: "q.iter().all(|c| c.abs() <= 1.0)",
            wrong: "q.iter().all(|c| c.abs() <= 4.0)",
        }],
        "beyond_the_frame_no_sphere_decides",
        "core/kernel/src/sphere/tests.rs",
    ),
    seen(
        14,
        "the vector path has a quarter of the proved tolerance",
        &[Edit {
            file: "core/kernel/src/sphere/simd.rs",
            right: "_mm_set1_ps(TOLERANCE)",
            wrong: "_mm_set1_ps(TOLERANCE / 4.0)",
        }],
        "within_the_tolerance_nothing_is_decided_and_just_beyond_it_all_is",
        "core/kernel/src/sphere/tests.rs",
    ),
    seen(
        15,
        "the checker's ratio test never goes to integers",
        &[Edit {
            file: "verify/checker/src/conform/bounds.rs",
            right: "(left - right).abs() > error",
            wrong: "true",
        }],
        "the_ratio_is_compared_in_integers_where_doubles_are_wrong",
        "verify/checker/src/conform/bounds.rs",
    ),
    seen(
        16,
        "free segments are not looked for",
        &[Edit {
            file: "verify/checker/src/conform/incidence.rs",
            right: "sides.chain(segments).collect()",
            wrong: "sides.collect()",
        }],
        "a_free_segment_must_be_a_chain_of_edges",
        "verify/checker/tests/domains.rs",
    ),
    Slip {
        number: 17,
        what: "of coplanar hull facets the circle is not tested",
        edits: &[Edit {
            file: "verify/checker/src/hull.rs",
            right: "mesh.in_sphere(t, q, &mut part.tally)",
            wrong: "match mesh.in_sphere(t, q, &mut part.tally) { 1 => -1, other => other }",
        }],
        test: "no_verdict_rests_on_the_circles_of_coplanar_hull_facets_alone",
        at: "verify/checker/tests/meshes.rs",
        is_equivalent: true,
    },
    seen(
        18,
        "-0.0 is not 0.0 in the hash",
        &[Edit {
            file: "core/kernel/src/hash.rs",
            right: "points[v as usize].map(|c| c + 0.0)",
            wrong: "points[v as usize]",
        }],
        "",
        "core/kernel/tests/canonical_hash.rs",
    ),
    seen(
        19,
        "a symbolic link is replaced, not followed",
        &[Edit {
            file: "core/formats/src/atomic_file.rs",
            right: "std::fs::canonicalize(path)",
            wrong: "Ok(path.to_owned())",
        }],
        "a_link_is_followed_and_modes_are_ordinary",
        "core/formats/src/atomic_file.rs",
    ),
    seen(
        20,
        "sizes and the background mesh may be overwritten by an output",
        &[
            Edit {
                file: "cli/src/mesh.rs",
                right: "inputs.extend(args.sizing.sizes.iter().map(|sizes| sizes.file.clone()))",
                wrong: "",
            },
            Edit {
                file: "cli/src/mesh.rs",
                right: "inputs.extend(args.sizing.background.iter().flat_map(io::mesh_files))",
                wrong: "",
            },
        ],
        "sizes_and_the_background_mesh_are_not_overwritten",
        "cli/tests/rejected.rs",
    ),
    seen(
        21,
        "the tags of regions 2 and 3 are swapped",
        &[Edit {
            file: "core/refine/src/output/refined.rs",
            right: "i64::from(self.region(t))",
            wrong: "match self.region(t) { 2 => 3, 3 => 2, own => i64::from(own) }",
        }],
        "tetrahedra_have_the_tags_of_the_seeds_in_them",
        "core/refine/tests/regions.rs",
    ),
    seen(
        22,
        "Gone is counted by neither side, and no barrier waits for it",
        &[
            Edit {
                file: "parallel/src/refining/rounds/decide.rs",
                right: "self.counts.asks += 1;
        self.send(self.keeper(mesh, item), DomainNews::Gone(item.place()));",
                wrong: "self.send(self.keeper(mesh, item), DomainNews::Gone(item.place()));",
            },
            Edit {
                file: "parallel/src/refining/rounds/source.rs",
                right: "self.counts.asks -= 1;
                self.demands.gone.push(place);",
                wrong: "self.demands.gone.push(place);",
            },
        ],
        "no_message_is_behind_the_barrier_that_waits_for_it_however_late",
        "parallel/src/refining/rounds/stages/tests.rs",
    ),
];
