//! The conformance kit `verify/vectors`: its cases, made by the real code and compared with slow
//! twins that share none of it. `cargo xtask vectors` writes them; a test holds the files to this.
//!
//! | module | folder |
//! |---|---|
//! | [`hex`] | numbers as text |
//! | [`predicates`] | `predicates/` |
//! | [`order`] | `order/` |
//! | [`meshes`] | `cavity/`, `insert/`, `delaunay/` |
//! | [`mod@line`] | the mesh of `protocol/`: intervals on a line |
//! | [`letters`] | messages over the line and over the hull of the models as JSON |
//! | [`world`] | workers, run event by event |
//! | [`quiet`] | runs of known-bad variants that panic |
//! | [`protocol`] | `protocol/`, `interleavings/` |
//! | [`rounds`] | `rounds/` |

#![forbid(unsafe_code)]

pub mod hex;
pub mod letters;
pub mod line;
pub mod meshes;
pub mod order;
pub mod predicates;
pub mod protocol;
pub mod quiet;
pub mod rounds;
pub mod world;

use ltbw::Point;
use serde_json::{Map, Value, json};
use std::sync::OnceLock;

/// The kit's own version: a changed answer or format is a new major one, new cases a minor one.
pub const VERSION: &str = "5.1.0";

/// One question and its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The subject of the case, in a few words.
    pub name: String,
    /// The mistakes that make an implementation fail it.
    pub flags: Vec<&'static str>,
    /// The question: `op` and its arguments.
    pub ask: Value,
    /// The answer.
    pub expect: Value,
}

/// One file of the kit.
#[derive(Clone, Debug)]
pub struct File {
    /// Its folder.
    pub folder: &'static str,
    /// Its name without `.json`.
    pub name: &'static str,
    /// 1: can be checked by hand; 2: ordinary; 3: hard.
    pub tier: u32,
    /// The questions of the file, for people.
    pub about: &'static str,
    /// The cases.
    pub cases: Vec<Case>,
}

/// Every flag, and what a failure under it tells.
pub const FLAGS: &[(&str, &str)] = &[
    ("sign-convention", "orientation or in-sphere test of the opposite sign"),
    ("rounded", "a sign was taken from a rounded number: near ties need exact arithmetic"),
    ("range", "products under- or overflow: exact arithmetic must span all of f64"),
    ("negative-zero", "-0.0 and 0.0 were taken for different coordinates"),
    ("tie", "cospherical points: the symbolic perturbation is missing"),
    ("tie-order", "the perturbation does not go by (x, y, z), the largest point first"),
    ("second-round", "the perturbation stops at its first coefficient, which is zero here"),
    ("hull-plane", "a point in the plane of a hull facet: its perturbed circle decides"),
    ("hull", "ghosts are missing or turned the wrong way: points beyond the hull"),
    ("hilbert-curve", "another curve, other axes, or another first octant"),
    ("hilbert-cell", "the cell of a point is rounded otherwise"),
    ("hilbert-run", "runs of equal keys are not ordered again in their own box"),
    ("brio-hash", "another hash or another count of rounds"),
    ("majority", "the block of a tetrahedron: majority of its finite vertices, then the smallest"),
    ("ring", "the ring is not the cavity's face neighbours"),
    ("duplicate", "equal points: the smallest index is the vertex"),
    ("hash", "the mesh is right, its canonical hash is not"),
    ("local", "a local insertion was made an operation, or the other way round"),
    ("closure-ring", "the ring of the closure is not locked"),
    ("wound", "an older request does not wound the holder, or a younger one does"),
    ("late-wound", "a wound after the commit point was obeyed"),
    ("regrant", "a released lock was offered to one of those that wait for it, not to all"),
    ("place", "a request asked again while it waits turned to the new wants first"),
    ("acknowledge", "an operation started again before all its releases were acknowledged"),
    ("release", "a setback kept a lock, or did not wake those who wait for it"),
    ("installation", "a tetrahedron that is not installed yet was taken for nothing"),
    ("waiters", "a block left, and those that wait for its cells to be installed were not told"),
    ("relink", "a ring cell of another owner kept a link to a cell that is gone"),
    ("names", "a name was given twice"),
    ("cancel", "a cancelled worker went on with the points of a block that moved to it"),
    ("cells", "a cavity of several cells of one owner"),
    ("two-faces", "a ring cell with two faces on the cavity: asked for once, linked anew twice"),
    ("bounce", "a seed for a block that has moved must be bounced with the news"),
    ("forward", "a walk or late tetrahedra must follow a block that has moved"),
    ("idle-migration", "a passive worker gave a block away"),
    ("locked-migration", "a block with a locked tetrahedron was given away"),
    ("token", "termination detection: counts, colours or who tells whom"),
    ("rule", "the paper's rule decides otherwise"),
    ("key", "another size, another hash, or corners not sorted by x, y, z"),
    ("foremost", "a tetrahedron over its bounds with a larger key beside it is no candidate"),
    ("foremost-beyond", "the face neighbours of the face neighbours count, whatever is between"),
    ("kill", "a candidate dies if one before it has its tetrahedron, not if cavities only meet"),
    ("kill-chain", "a candidate that is killed kills others all the same"),
    ("tree", "the sums of a barrier: who tells whom, and when"),
    ("second-wave", "insertion ends with two equal waves in which as many were sent as taken"),
];

/// All files of the kit, made once.
#[must_use]
pub fn kit() -> &'static [File] {
    static KIT: OnceLock<Vec<File>> = OnceLock::new();
    KIT.get_or_init(|| {
        let (protocol, rounds) = (protocol::files(), rounds::files());
        [predicates::files(), order::files(), meshes::files(), protocol, rounds].concat()
    })
}

/// A generated file.
#[derive(Clone, Debug)]
pub struct Generated {
    /// Its path inside `verify/vectors`.
    pub path: String,
    /// Its text.
    pub text: String,
}

/// Every generated file.
#[must_use]
pub fn files() -> Vec<Generated> {
    let path = |file: &File| format!("{}/{}.json", file.folder, file.name);
    kit().iter().map(|file| Generated { path: path(file), text: text(file) }).collect()
}

/// A file as JSON, one case a line.
fn text(file: &File) -> String {
    let mut used: Vec<&str> = file.cases.iter().flat_map(|case| case.flags.clone()).collect();
    used.sort_unstable();
    used.dedup();
    let meaning = |flag: &str| {
        let known = FLAGS.iter().find(|(name, _)| *name == flag);
        known.unwrap_or_else(|| panic!("flag {flag} has no meaning")).1
    };
    let flags: Map<String, Value> =
        used.iter().map(|&flag| (flag.to_string(), json!(meaning(flag)))).collect();
    let lines: Vec<String> = (1..)
        .zip(&file.cases)
        .map(|(number, case)| {
            let id = format!("{}/{}/{number}", file.folder, file.name);
            let Case { name, flags, ask, expect } = case;
            json!({"id": id, "name": name, "flags": flags, "ask": ask, "expect": expect})
                .to_string()
        })
        .collect();
    format!(
        "{{\n\"kit\": \"{VERSION}\",\n\"folder\": \"{}\",\n\"tier\": {},\n\"about\": {},\n\
         \"flags\": {},\n\"cases\": [\n{}\n]\n}}\n",
        file.folder,
        file.tier,
        json!(file.about),
        Value::Object(flags),
        lines.join(",\n"),
    )
}

/// Points as JSON.
fn write(points: &[Point]) -> Value {
    points.iter().map(|p| json!(p.map(hex::to_hex))).collect()
}
