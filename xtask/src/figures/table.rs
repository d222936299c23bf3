//! The tables and figures that pages quote, and the commands that print them. A test reads this
//! list beside the pages (`tests/tests/tidy/figures.rs`).

/// Figures that are printed together.
pub(crate) struct Figures {
    pub(crate) name: &'static str,
    /// The sections that quote them.
    pub(crate) places: &'static [Place],
    /// The commands, as one types them. [`PARTS`] is a folder of surfaces.
    pub(crate) commands: &'static [&'static str],
}

/// A section of a page: its heading, or none for the whole page.
pub(crate) struct Place {
    pub(crate) page: &'static str,
    pub(crate) heading: &'static str,
}

/// The word of a command that stands for the folder of surfaces that `LTBW_PARTS` names.
pub(crate) const PARTS: &str = "DIR";

const fn at(page: &'static str, heading: &'static str) -> Place {
    Place { page, heading }
}

/// All of them, in the order of the pages.
pub(crate) const FIGURES: &[Figures] = &[
    Figures {
        name: "points",
        places: &[at("README.md", "ltbw"), at("README.md", "Speed")],
        commands: &["cargo xtask bench uniform grid clusters moment-curve skew-lines \
                     rounded-sphere shell"],
    },
    Figures {
        name: "beside",
        places: &[at("README.md", "Speed"), at("docs/quality.md", "Beside others")],
        commands: &["cargo xtask bench quality"],
    },
    Figures {
        name: "coverage",
        places: &[at("docs/coverage.md", "")],
        commands: &["cargo xtask coverage"],
    },
    Figures {
        name: "processes",
        places: &[at("docs/distributed.md", "The simulator beside processes")],
        commands: &["cargo xtask mpi --validate"],
    },
    Figures {
        name: "beside-threads",
        places: &[at("docs/distributed.md", "Two processes beside two threads")],
        commands: &["cargo xtask mpi --speed"],
    },
    Figures {
        name: "faults",
        places: &[at("docs/distributed.md", "When something fails")],
        commands: &["cargo xtask mpi --faults 600"],
    },
    Figures {
        name: "stages",
        places: &[at("docs/numerics.md", "Numerics")],
        commands: &["cargo run --release -p ltbw-core --example build_speed -- uniform 1000000 1"],
    },
    Figures {
        name: "filters",
        places: &[at("docs/numerics.md", "Filters")],
        commands: &["cargo xtask prove"],
    },
    Figures {
        name: "paper",
        places: &[at("docs/paper-tables.md", "")],
        commands: &["cargo xtask paper"],
    },
    Figures {
        name: "variants",
        places: &[at("docs/protocol-variants.md", "The paper's variants")],
        commands: &[
            "ltbw simulate --processors 16 --points 960000 --latency 100us --balance",
            "ltbw simulate --processors 16 --points 960000 --latency 100us --ownership newest",
            "ltbw simulate --processors 16 --points 960000 --latency 100us --ownership creator",
            "ltbw simulate --processors 16 --points 960000 --latency 100us --balance --rule paper",
            "ltbw simulate --processors 16 --points 960000 --latency 100us --rule paper \
             --closure vertex --ownership creator",
        ],
    },
    Figures {
        name: "polling",
        places: &[at("docs/protocol-variants.md", "The paper's variants")],
        commands: &[
            "ltbw simulate --machine cow --processors 32 --points 1200000 --balance",
            "ltbw simulate --machine cow --processors 32 --points 1200000 --balance --poll-every 2",
            "ltbw simulate --machine cow --processors 32 --points 1200000 --balance --poll-every 8",
        ],
    },
    Figures {
        name: "iterations",
        places: &[at("docs/quality.md", "What small angles cost")],
        commands: &["cargo xtask bench iterations"],
    },
    Figures {
        name: "small-angles",
        places: &[at("docs/quality.md", "Beside others")],
        commands: &["LTBW_CASES=100 cargo test -p ltbw-tests --test workspace \
                     random_domains_have_few_small_angles -- --nocapture"],
    },
    Figures {
        name: "rounds",
        places: &[at("docs/rounds.md", "Speed")],
        commands: &["cargo xtask bench refine"],
    },
    Figures {
        name: "processors",
        places: &[at("docs/rounds.md", "Speed")],
        commands: &[
            "ltbw simulate --domain cube-octahedron --max-volume 1.73783e-6 --processors 16 \
             --latency 1us",
            "ltbw simulate --domain cube-octahedron --max-volume 1.73783e-6 --processors 16 \
             --latency 100us",
            "ltbw simulate --domain cube-octahedron --max-volume 1.73783e-6 --processors 64 \
             --latency 1.2us",
            "ltbw simulate --domain cube-octahedron --max-volume 1.73783e-7 --processors 256 \
             --latency 1.2us",
        ],
    },
    Figures {
        name: "many-processes",
        places: &[at("docs/distributed.md", "What does not scale yet")],
        commands: &[
            "ltbw simulate --processors 128 --points 7680000 --latency 10us --as-processes",
            "ltbw simulate --processors 1024 --points 4096000 --latency 10us --as-processes",
        ],
    },
    Figures {
        name: "freely",
        places: &[at("docs/rounds.md", "Without rounds, on many processors")],
        commands: &["LTBW_CASES=100 cargo test --release -p ltbw-tests --test workspace \
                     domains_have_as_many_tetrahedra -- --nocapture"],
    },
    Figures {
        name: "parts",
        places: &[
            at("docs/rounds.md", "Speed"),
            at("docs/refinement.md", "What has to be excused"),
        ],
        commands: &["cargo xtask parts --twins", "cargo xtask parts DIR --twins"],
    },
    Figures {
        name: "checker",
        places: &[at("verify/checker/README.md", "Cost")],
        commands: &[
            "cargo run --release -p ltbw-cli --example check_speed -- uniform 1000000 2 5 \
                     unaided",
        ],
    },
];
