//! The common parts of the two versions of `.msh`: nodes and tetrahedra under numbers of the
//! file, and how they become a mesh.

use crate::curved::Curved;
use crate::error::Reason;
use crate::faces::{Marked, owned};
use crate::scalar::exact_integer;
use crate::{GroupName, MeshFile};
use ltbw_core::TetMesh;
use ltbw_exact::Point;
use std::collections::{HashMap, HashSet};

/// The cells of an element type, as far as they matter here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// Of dimension 0 to 2, and no triangles.
    Other,
    Triangle,
    Tetrahedron,
}

/// The cells of an element type and their number of nodes, of which the corners are the first, by
/// Gmsh's number for the type. Source: the Gmsh reference manual, "MSH file format".
pub(super) fn element_type(number: i64) -> Option<(Shape, u64)> {
    Some(match number {
        15 => (Shape::Other, 1),
        1 => (Shape::Other, 2),
        8 => (Shape::Other, 3),
        26 => (Shape::Other, 4),
        27 => (Shape::Other, 5),
        28 => (Shape::Other, 6),
        TRIANGLE => (Shape::Triangle, 3),
        9 => (Shape::Triangle, 6),
        20 => (Shape::Triangle, 9),
        21 => (Shape::Triangle, 10),
        22 => (Shape::Triangle, 12),
        23 | 24 => (Shape::Triangle, 15),
        25 => (Shape::Triangle, 21),
        3 => (Shape::Other, 4),
        10 => (Shape::Other, 9),
        16 => (Shape::Other, 8),
        TETRAHEDRON => (Shape::Tetrahedron, 4),
        11 => (Shape::Tetrahedron, 10),
        29 => (Shape::Tetrahedron, 20),
        30 => (Shape::Tetrahedron, 35),
        31 => (Shape::Tetrahedron, 56),
        _ => return None,
    })
}

/// Gmsh's number for a tetrahedron of four nodes.
pub(super) const TETRAHEDRON: i64 = 4;

/// Gmsh's number for a triangle of three nodes.
pub(super) const TRIANGLE: i64 = 2;

/// The nodes of a file.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    pub(super) points: Vec<Point>,
    /// The number of each node in the file.
    pub(super) numbers: Vec<u64>,
    /// Nodes by number, sorted, unless they are numbered in turn.
    sorted: Vec<(u64, u32)>,
}

impl Nodes {
    /// Finishes the list, after which [`Nodes::index`] answers.
    pub(super) fn finish(&mut self) -> Result<(), Reason> {
        let count = self.numbers.len();
        u32::try_from(count).map_err(|_| Reason::TooManyPoints(count as u64))?;
        if in_turn(self.numbers.iter().copied()) {
            return Ok(());
        }
        self.sorted = self.numbers.iter().zip(0..).map(|(&number, i)| (number, i)).collect();
        self.sorted.sort_unstable();
        match self.sorted.windows(2).find(|w| w[0].0 == w[1].0) {
            Some(w) => Err(Reason::Syntax(format!("two nodes have the number {}", w[0].0))),
            None => Ok(()),
        }
    }

    /// Keeps some of them, in their order.
    fn keep(&mut self, is_kept: &[bool]) {
        let mut kept = is_kept.iter();
        self.points.retain(|_| kept.next() == Some(&true));
        let mut kept = is_kept.iter();
        self.numbers.retain(|_| kept.next() == Some(&true));
        // Numbers that are different stay so.
        self.sorted = self.numbers.iter().zip(0..).map(|(&number, i)| (number, i)).collect();
        self.sorted.sort_unstable();
    }

    /// The index of the node with a number.
    pub(super) fn index(&self, number: u64) -> Option<u32> {
        if self.sorted.is_empty() {
            // Numbered from 1.
            let index = number.checked_sub(1)?;
            return ((index as usize) < self.points.len()).then_some(index as u32);
        }
        let at = self.sorted.binary_search_by_key(&number, |&(n, _)| n).ok()?;
        Some(self.sorted[at].1)
    }
}

/// Are these the numbers 1, 2, 3 and so on?
fn in_turn(mut numbers: impl Iterator<Item = u64>) -> bool {
    let mut expected = 0;
    numbers.all(|n| {
        expected += 1;
        n == expected
    })
}

/// A tetrahedron of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tet {
    pub(super) number: u64,
    pub(super) corners: [u32; 4],
    /// Its physical group; 0: none.
    pub(super) physical: i64,
    /// Its geometrical entity.
    pub(super) entity: i64,
}

/// A triangle of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) number: u64,
    pub(super) corners: [u32; 3],
    /// Its physical group; 0: none.
    pub(super) physical: i64,
}

/// Everything that is read from a file.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) nodes: Option<Nodes>,
    pub(super) tets: Option<Vec<Tet>>,
    pub(super) triangles: Vec<Triangle>,
    /// Markers of the groups of surfaces whose names tell them.
    pub(super) markers: HashMap<i64, i64>,
    /// Other names of groups of surfaces and volumes.
    pub(super) names: Vec<GroupName>,
    /// Values of the view `tag` at nodes, by number.
    pub(super) tags: Option<Vec<Datum>>,
    /// Values of the view `region` in elements, by number.
    pub(super) regions: Option<Vec<Datum>>,
    /// Numbers of elements that are copies of those of another partition.
    pub(super) ghosts: HashSet<u64>,
    pub(super) other_elements: bool,
    pub(super) several_groups: bool,
    pub(super) curved: Curved,
    pub(super) notes: Vec<String>,
}

impl Parts {
    /// The corners of element `number`, from the numbers of its nodes.
    pub(super) fn corners<const N: usize>(
        &self,
        number: u64,
        nodes: [u64; N],
    ) -> Result<[u32; N], Reason> {
        let mut corners = [0; N];
        let list = self.nodes.as_ref();
        for (corner, node) in corners.iter_mut().zip(nodes) {
            *corner = list.and_then(|l| l.index(node)).ok_or_else(|| {
                Reason::Syntax(format!("element {number} names node {node}, which is not there"))
            })?;
        }
        Ok(corners)
    }

    /// Leaves out copies of elements, and the nodes that no other element has.
    fn without_ghosts(&mut self) {
        let Self { nodes: Some(nodes), tets: Some(tets), triangles, ghosts, .. } = self else {
            return;
        };
        if ghosts.is_empty() {
            return;
        }
        tets.retain(|tet| !ghosts.contains(&tet.number));
        triangles.retain(|triangle| !ghosts.contains(&triangle.number));
        let mut is_used = vec![false; nodes.points.len()];
        let own = tets.iter().flat_map(|tet| tet.corners);
        own.chain(triangles.iter().flat_map(|t| t.corners))
            .for_each(|v| is_used[v as usize] = true);
        let mut places = Vec::with_capacity(is_used.len());
        let mut count = 0;
        for &is_used in &is_used {
            places.push(count);
            count += u32::from(is_used);
        }
        tets.iter_mut().for_each(|tet| tet.corners = tet.corners.map(|v| places[v as usize]));
        triangles.iter_mut().for_each(|t| t.corners = t.corners.map(|v| places[v as usize]));
        nodes.keep(&is_used);
    }

    /// The mesh: nodes in the order of the file, tetrahedra in the order of their numbers.
    pub(super) fn mesh(mut self) -> Result<MeshFile, Reason> {
        self.without_ghosts();
        let Parts { nodes, tets, mut triangles, markers, mut names, .. } = self;
        let (tags, regions, mut notes) = (self.tags, self.regions, self.notes);
        let missing = |name| Reason::Syntax(format!("there is no section `{name}`"));
        let nodes = nodes.ok_or_else(|| missing("$Nodes"))?;
        // A file that was cut between sections must not pass for a mesh without elements.
        let mut tets = tets.ok_or_else(|| missing("$Elements"))?;
        tets.sort_by_key(|t| t.number);
        if self.other_elements {
            notes
                .push("elements that are neither tetrahedra nor triangles are not read".to_owned());
        }
        if self.several_groups {
            notes.push("of several physical groups of an entity only the first is read".to_owned());
        }
        notes.extend(self.curved.note());
        let point_tags = tags.and_then(|values| {
            let tags = whole(&values, nodes.points.len(), |n| nodes.index(n).map(|i| i as usize));
            if tags.is_none() {
                notes.push("the data `tag` is not read: not an integer at every node".to_owned());
            }
            tags
        });
        let by_number = |n| tets.binary_search_by_key(&n, |t| t.number).ok();
        let from_data = regions.and_then(|values| {
            let tags = whole(&values, tets.len(), by_number);
            if tags.is_none() {
                let text = "the data `region` is not read: not an integer in every tetrahedron";
                notes.push(text.to_owned());
            }
            tags
        });
        let grouped = from_data.is_some() || tets.iter().any(|t| t.physical != 0);
        let tet_tags = from_data.or_else(|| groups(&tets));
        if tet_tags.is_some() && !grouped && names.iter().any(|n| n.dimension == 3) {
            // They would name geometrical entities that have the same numbers.
            names.retain(|n| n.dimension != 3);
            notes.push("names of physical groups without tetrahedra are not read".to_owned());
        }
        let tets = tets.iter().map(|t| t.corners).collect();
        let points = nodes.points;
        let mut mesh = TetMesh { points, tets, point_tags, tet_tags, ..TetMesh::default() };
        triangles.sort_by_key(|t| t.number);
        let marker = |t: &Triangle| markers.get(&t.physical).copied().unwrap_or(t.physical);
        let marked = |t: &Triangle| Marked { corners: t.corners, marker: marker(t) };
        let triangles: Vec<Marked> = triangles.iter().map(marked).collect();
        let note;
        (mesh.faces, note) = owned(&mesh, &triangles);
        notes.extend(note);
        Ok(MeshFile { mesh, notes, names })
    }
}

/// The value of a view at a node or an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Datum {
    /// The number of the node or element.
    pub(super) number: u64,
    pub(super) value: f64,
}

/// The values as integers in the order of `count` things, if each has one.
fn whole(values: &[Datum], count: usize, index: impl Fn(u64) -> Option<usize>) -> Option<Vec<i64>> {
    let mut found = vec![None; count];
    // Data of elements may be given for triangles, too.
    for datum in values {
        if let Some(i) = index(datum.number) {
            found[i] = exact_integer(datum.value);
        }
    }
    found.into_iter().collect()
}

/// Regions by physical groups, or by geometrical entities where there are several and no groups.
fn groups(tets: &[Tet]) -> Option<Vec<i64>> {
    if tets.iter().any(|t| t.physical != 0) {
        return Some(tets.iter().map(|t| t.physical).collect());
    }
    let several = tets.windows(2).any(|w| w[0].entity != w[1].entity);
    several.then(|| tets.iter().map(|t| t.entity).collect())
}
