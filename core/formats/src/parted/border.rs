//! Borders of the parts of a mesh: shared vertices, edges and faces with the
//! parts that have them, numbers of all vertices and tetrahedra, copies of the tetrahedra beside.
//!
//! Each part takes five steps, and tells the others something between them: lists of words, by
//! receiver out, by sender in. Whoever has all parts calls [`borders`]; members of a team have
//! their own way to exchange the words.
//!
//! | step | what it tells |
//! |---|---|
//! | [`Bordering::begin`] | vertices, edges and faces of the own surface, to whoever they meet at |
//! | [`Bordering::meet`] | to whom each one that met here belongs, too |
//! | [`Bordering::number`] | how many vertices and tetrahedra it owns; numbers of shared vertices |
//! | [`Bordering::reach`] | the tetrahedra at shared vertices |
//! | [`Bordering::finish`] | nothing |
//!
//! A shared vertex is owned by the first part that has it. Numbers are sums over the parts before:
//! those of part 0 come first. All lists are in the order of the numbers in the whole mesh, and so
//! of one order at every part.

use super::files::{PartOf, Piece};
use super::words::{Words, numbers, place, triple};
use crate::error::BorderError;
use ltbw_core::TetMesh;
use ltbw_exact::Point;
use rayon::prelude::*;
use std::collections::HashMap;

/// Stands where a vertex or an edge has no further corner.
const NONE: u32 = u32::MAX;

/// A vertex, an edge or a face: its numbers in the whole mesh, ascending, then [`NONE`].
type Item = [u32; 3];

/// A vertex, an edge or a face that several parts have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Common<const N: usize> {
    /// Its corners by their places in the part, in the order of their numbers in the whole.
    pub corners: [u32; N],
    /// The parts that have it, ascending.
    pub parts: Vec<u32>,
}

/// A copy of a tetrahedron of another part, which has a vertex in common with this one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ghost {
    /// The part that it is in.
    pub owner: u32,
    /// Its number in the whole mesh.
    pub number: u64,
    /// Its corners: places among the points of the part, and then among [`Border::points`].
    pub corners: [u32; 4],
}

/// A vertex of a copied tetrahedron that the part has not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GhostPoint {
    /// Its number in the input.
    pub given: u32,
    /// Its number in the whole mesh, as in [`Border::numbers`].
    pub number: u64,
    /// Its coordinates.
    pub at: Point,
}

/// The border of a part: all that it has in common with the others.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Border {
    /// For each point its number in the whole mesh, from 0: those that a part owns in turn.
    pub numbers: Vec<u64>,
    /// Points of the whole mesh, and those that the parts before this one own.
    pub all_points: u64,
    /// Points that the parts before this one own.
    pub points_before: u64,
    /// Tetrahedra of the whole mesh.
    pub all_tets: u64,
    /// Tetrahedra of the parts before this one.
    pub tets_before: u64,
    /// Boundary faces of the parts before this one.
    pub faces_before: u64,
    /// Vertices that other parts have, too.
    pub vertices: Vec<Common<1>>,
    /// Edges that other parts have, too.
    pub edges: Vec<Common<2>>,
    /// Faces that another part has, too.
    pub faces: Vec<Common<3>>,
    /// Faces that no other tetrahedron has, seen from outside in counterclockwise order.
    pub hull: Vec<[u32; 3]>,
    /// Copies of the tetrahedra of others that have a vertex of this part, by number.
    pub ghosts: Vec<Ghost>,
    /// Their vertices that this part has not, by number in the input.
    pub points: Vec<GhostPoint>,
    /// The different regions of all parts, ascending.
    pub regions: Vec<i64>,
    /// The different markers of all parts, ascending.
    pub markers: Vec<i64>,
}

impl Border {
    /// For each of the points of a part the first part that has it.
    pub(crate) fn owners(&self, part: u32, points: usize) -> Vec<u32> {
        let mut owners = vec![part; points];
        self.vertices.iter().for_each(|own| owners[own.corners[0] as usize] = own.parts[0]);
        owners
    }
}

/// A part on the way to its [`Border`].
#[derive(Debug)]
pub struct Bordering<'a> {
    mesh: &'a TetMesh,
    given: &'a [u32],
    place: PartOf,
    /// The surface: vertices, edges and faces, ascending, and by whom each is asked for.
    items: Vec<Item>,
    /// Oriented faces of the surface, by the item.
    surface: HashMap<Item, [u32; 3]>,
    /// For each point its place in the list of shared vertices.
    shared: Vec<u32>,
    border: Border,
}

impl<'a> Bordering<'a> {
    /// A part, and what it tells the others first.
    ///
    /// # Errors
    /// [`BorderError`] if the part is none.
    pub fn begin(piece: &'a Piece, place: PartOf) -> Result<(Self, Words), BorderError> {
        let Piece { mesh, numbers: given } = piece;
        let (points, length) = (mesh.points.len(), mesh.tets.len());
        let refused = |at, what| BorderError { part: place.part, at, length, what };
        let is_listed = given.len() == points && given.is_sorted_by(|a, b| a < b);
        if !is_listed || given.last() == Some(&NONE) {
            return Err(refused(0, "numbers of points that do not ascend"));
        }
        let is_foreign = |tet: &[u32; 4]| tet.iter().any(|&v| v as usize >= points);
        if let Some(at) = mesh.tets.iter().position(is_foreign) {
            return Err(refused(at, "a tetrahedron names a point that is not there"));
        }
        if length > NONE as usize / 4 {
            return Err(refused(length, "more tetrahedra than a part can have"));
        }
        let surface =
            surface_of(&mesh.tets).map_err(|at| refused(at, "a third tetrahedron at a face"))?;
        let named = |face: [u32; 3]| item(face.map(|v| given[v as usize]));
        let surface: HashMap<Item, [u32; 3]> =
            surface.into_iter().map(|face| (named(face), face)).collect();
        let parts_of = |&[a, b, c]: &Item| {
            let edges = [[a, b, NONE], [a, c, NONE], [b, c, NONE]];
            [a, b, c].map(|v| [v, NONE, NONE]).into_iter().chain(edges).chain([[a, b, c]])
        };
        let mut items: Vec<Item> = surface.keys().flat_map(parts_of).collect();
        items.par_sort_unstable();
        items.dedup();
        let mut out = vec![Vec::new(); place.of];
        for own in &items {
            out[meeting(own, place.of)].extend(words(own));
        }
        let (shared, border) = (vec![NONE; points], Border::default());
        Ok((Self { mesh, given, place, items, surface, shared, border }, out))
    }

    /// Tells each part who else has what it asks for.
    ///
    /// # Errors
    /// [`BorderError`] if a part asks for what makes no sense.
    pub fn meet(&self, asked: &[Vec<u64>]) -> Result<Words, BorderError> {
        let mut all: Vec<(Item, u32)> = Vec::new();
        for (part, words) in asked.iter().enumerate() {
            let items = items_of(part, words)?;
            all.extend(items.into_iter().map(|own| (own, part as u32)));
        }
        all.par_sort_unstable();
        let mut out = vec![Vec::new(); self.place.of];
        for (part, words) in asked.iter().enumerate() {
            for (at, own) in items_of(part, words)?.into_iter().enumerate() {
                let from = all.partition_point(|other| *other < (own, 0));
                let same = all[from..].iter().take_while(|other| other.0 == own);
                let others: Vec<u64> =
                    same.map(|other| u64::from(other.1)).filter(|&k| k != part as u64).collect();
                if own[2] != NONE && others.len() > 1 {
                    let what = "a face that two other parts have, too";
                    return Err(BorderError { part, at: 2 * at, length: words.len(), what });
                }
                out[part].push(others.len() as u64);
                out[part].extend(others);
            }
        }
        Ok(out)
    }

    /// Finds out what is shared, by the answers to what it has asked; tells others its counts, and
    /// numbers of the shared vertices that it owns.
    ///
    /// # Errors
    /// [`BorderError`] if an answer makes no sense.
    pub fn number(&mut self, answers: &[Vec<u64>]) -> Result<Words, BorderError> {
        let mut at = vec![0; self.place.of];
        let me = self.place.part as u32;
        for own in std::mem::take(&mut self.items) {
            let part = meeting(&own, self.place.of);
            let (answer, at) = (&answers[part], &mut at[part]);
            let count = place(part, answer, *at, self.place.of)?;
            let mut parts = vec![me];
            for k in 1..=count {
                parts.push(place(part, answer, *at + k, self.place.of)? as u32);
            }
            *at += 1 + count;
            parts.sort_unstable();
            self.keep(&own, parts);
        }
        let border = &mut self.border;
        for (k, common) in (0..).zip(&border.vertices) {
            self.shared[common.corners[0] as usize] = k;
        }
        let is_own = |v: &u32| match self.shared[*v as usize] {
            NONE => true,
            k => border.vertices[k as usize].parts[0] == me,
        };
        let owned: Vec<u32> = (0..self.mesh.points.len() as u32).filter(is_own).collect();
        // Among those that the part owns; the others are told.
        border.numbers = vec![u64::MAX; self.mesh.points.len()];
        (0..).zip(&owned).for_each(|(k, &v)| border.numbers[v as usize] = k);
        let counts = [owned.len(), self.mesh.tets.len(), self.mesh.faces.len()];
        let mut head = counts.map(|count| count as u64).to_vec();
        let markers: Vec<i64> = self.mesh.faces.iter().map(|face| face.marker).collect();
        for all in [self.mesh.tet_tags.clone().unwrap_or_default(), markers] {
            let all = different(all);
            head.push(all.len() as u64);
            head.extend(all.into_iter().map(|value| value as u64));
        }
        let mut out = vec![head; self.place.of];
        for common in border.vertices.iter().filter(|common| common.parts[0] == me) {
            let number = border.numbers[common.corners[0] as usize];
            common.parts[1..].iter().for_each(|&part| out[part as usize].push(number));
        }
        Ok(out)
    }

    /// Keeps an item of the surface that these parts have.
    fn keep(&mut self, own: &Item, parts: Vec<u32>) {
        let local = |v: u32| self.given.partition_point(|&other| other < v) as u32;
        let [a, b, c] = *own;
        let border = &mut self.border;
        match (parts.len(), b, c) {
            (1, _, NONE) => {}
            (1, ..) => border.hull.extend(self.surface.get(own)),
            (_, NONE, _) => border.vertices.push(Common { corners: [local(a)], parts }),
            (_, _, NONE) => border.edges.push(Common { corners: [a, b].map(local), parts }),
            _ => border.faces.push(Common { corners: own.map(local), parts }),
        }
    }

    /// Numbers the vertices, by what all have told; tells others the tetrahedra beside theirs.
    ///
    /// # Errors
    /// [`BorderError`] if a part has told what makes no sense.
    pub fn reach(&mut self, told: &[Vec<u64>]) -> Result<Words, BorderError> {
        let me = self.place.part;
        let mut firsts = Vec::with_capacity(told.len());
        let mut rest = Vec::with_capacity(told.len());
        let mut faces = 0_u64;
        let border = &mut self.border;
        for (part, words) in told.iter().enumerate() {
            let head = numbers(part, words, 0, 3)?;
            if part == me {
                (border.points_before, border.tets_before) = (border.all_points, border.all_tets);
                border.faces_before = faces;
            }
            firsts.push(border.all_points);
            border.all_points = border.all_points.saturating_add(head[0]);
            border.all_tets = border.all_tets.saturating_add(head[1]);
            faces = faces.saturating_add(head[2]);
            let mut at = 3;
            for list in [&mut border.regions, &mut border.markers] {
                let count = place(part, words, at, words.len())?;
                let own = numbers(part, words, at + 1, count)?;
                list.extend(own.iter().map(|&value| value as i64));
                at += 1 + count;
            }
            rest.push(&words[at..]);
        }
        border.regions = different(std::mem::take(&mut border.regions));
        border.markers = different(std::mem::take(&mut border.markers));
        let mut numbers = std::mem::take(&mut border.numbers);
        numbers.iter_mut().filter(|own| **own != u64::MAX).for_each(|own| *own += firsts[me]);
        let mut at = vec![0; told.len()];
        for common in border.vertices.iter().filter(|common| common.parts[0] as usize != me) {
            let part = common.parts[0] as usize;
            let Some(number) = rest[part].get(at[part]) else {
                let what = "fewer numbers than shared vertices";
                let length = told[part].len();
                return Err(BorderError { part, at: length, length, what });
            };
            numbers[common.corners[0] as usize] = firsts[part].saturating_add(*number);
            at[part] += 1;
        }
        border.numbers = numbers;
        Ok(self.beside())
    }

    /// The tetrahedra at shared vertices, by the other parts that have those.
    fn beside(&self) -> Words {
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); self.place.of];
        for (t, tet) in (0..).zip(&self.mesh.tets) {
            let shared = tet.iter().map(|&v| self.shared[v as usize]).filter(|&k| k != NONE);
            for &part in shared.flat_map(|k| &self.border.vertices[k as usize].parts) {
                if part as usize != self.place.part && lists[part as usize].last() != Some(&t) {
                    lists[part as usize].push(t);
                }
            }
        }
        lists.into_iter().map(|list| self.copied(&list)).collect()
    }

    /// Some tetrahedra with their vertices, as words.
    fn copied(&self, list: &[u32]) -> Vec<u64> {
        if list.is_empty() {
            return Vec::new();
        }
        let tets = list.iter().map(|&t| self.mesh.tets[t as usize]);
        let mut used: Vec<u32> = tets.clone().flatten().collect();
        used.sort_unstable();
        used.dedup();
        let mut out = vec![used.len() as u64];
        for &v in &used {
            let v = v as usize;
            out.extend([u64::from(self.given[v]), self.border.numbers[v]]);
            out.extend(self.mesh.points[v].map(f64::to_bits));
        }
        for (&t, tet) in list.iter().zip(tets) {
            out.push(self.border.tets_before + u64::from(t));
            let place = |v| used.partition_point(|&other| other < v) as u64;
            out.extend(tet.map(place));
        }
        out
    }

    /// Takes the tetrahedra beside its own.
    ///
    /// # Errors
    /// [`BorderError`] if a part has sent what is none.
    pub fn finish(self, sent: &[Vec<u64>]) -> Result<Border, BorderError> {
        let Self { given, mut border, .. } = self;
        let mut copies: Vec<(Ghost, [u32; 4])> = Vec::new();
        for (owner, words) in sent.iter().enumerate().filter(|(_, words)| !words.is_empty()) {
            let count = place(owner, words, 0, words.len())?;
            let rows = numbers(owner, words, 1, 5 * count)?;
            let mut points = Vec::with_capacity(count);
            for (k, row) in rows.chunks_exact(5).enumerate() {
                let point = GhostPoint {
                    given: place(owner, words, 1 + 5 * k, NONE as usize)? as u32,
                    number: row[1],
                    at: [row[2], row[3], row[4]].map(f64::from_bits),
                };
                points.push(point.given);
                if given.binary_search(&point.given).is_err() {
                    border.points.push(point);
                }
            }
            let mut at = 1 + 5 * count;
            while at < words.len() {
                let number = numbers(owner, words, at, 5)?[0];
                let mut corners = [0; 4];
                for (k, corner) in corners.iter_mut().enumerate() {
                    *corner = points[place(owner, words, at + 1 + k, count)?];
                }
                copies.push((Ghost { owner: owner as u32, number, corners: [0; 4] }, corners));
                at += 5;
            }
        }
        border.points.sort_unstable_by_key(|point| point.given);
        border.points.dedup_by_key(|point| point.given);
        let beyond = &border.points;
        let local = |v: u32| match given.binary_search(&v) {
            Ok(place) => place as u32,
            Err(_) => (given.len() + beyond.partition_point(|point| point.given < v)) as u32,
        };
        let placed =
            |(ghost, corners): (Ghost, [u32; 4])| Ghost { corners: corners.map(local), ..ghost };
        border.ghosts = copies.into_iter().map(placed).collect();
        border.ghosts.sort_unstable_by_key(|ghost| ghost.number);
        Ok(border)
    }
}

/// The borders of all parts of a mesh.
///
/// # Errors
/// [`BorderError`] if a part is none.
pub fn borders(parts: &[Piece]) -> Result<Vec<Border>, BorderError> {
    let of = parts.len();
    let (mut all, mut words) = (Vec::with_capacity(of), Vec::with_capacity(of));
    for (part, piece) in parts.iter().enumerate() {
        let (own, out) = Bordering::begin(piece, PartOf { part, of })?;
        all.push(own);
        words.push(out);
    }
    let step = |words: Vec<Words>| turned(words, of);
    let met: Result<Vec<Words>, _> =
        all.iter().zip(step(words)).map(|(own, words)| own.meet(&words)).collect();
    let numbered: Result<Vec<Words>, _> =
        all.iter_mut().zip(step(met?)).map(|(own, words)| own.number(&words)).collect();
    let reached: Result<Vec<Words>, _> =
        all.iter_mut().zip(step(numbered?)).map(|(own, words)| own.reach(&words)).collect();
    all.into_iter().zip(step(reached?)).map(|(own, words)| own.finish(&words)).collect()
}

/// Words by receiver, of words by sender.
fn turned(words: Vec<Words>, of: usize) -> Vec<Words> {
    let mut out: Vec<Words> = vec![Vec::with_capacity(of); of];
    for own in words {
        out.iter_mut().zip(own).for_each(|(to, words)| to.push(words));
    }
    out
}

/// Faces of one tetrahedron alone, seen from outside in counterclockwise order; else the
/// tetrahedron that is the third one at a face.
fn surface_of(tets: &[[u32; 4]]) -> Result<Vec<[u32; 3]>, usize> {
    let each = |(t, tet): (u32, &[u32; 4])| {
        let faces = faces_of(tet);
        [0, 1, 2, 3].map(|k| (item(faces[k as usize]), 4 * t + k))
    };
    let mut all: Vec<(Item, u32)> = Vec::with_capacity(4 * tets.len());
    all.extend((0..).zip(tets).flat_map(each));
    all.par_sort_unstable();
    let mut alone = Vec::new();
    for same in all.chunk_by(|a, b| a.0 == b.0) {
        match same {
            [(_, k)] => alone.push(faces_of(&tets[*k as usize / 4])[*k as usize % 4]),
            [_, _] => {}
            [.., (_, k)] => return Err(*k as usize / 4),
            [] => {}
        }
    }
    Ok(alone)
}

/// The faces of a positive tetrahedron, seen from outside in counterclockwise order.
fn faces_of(&[a, b, c, d]: &[u32; 4]) -> [[u32; 3]; 4] {
    [[b, c, d], [a, d, c], [a, b, d], [a, c, b]]
}

/// Three numbers, ascending.
fn item(mut numbers: [u32; 3]) -> Item {
    numbers.sort_unstable();
    numbers
}

/// The part at which an item meets its equals.
fn meeting([a, b, c]: &Item, of: usize) -> usize {
    let mix = |hash: u64, word: u32| (hash ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let hash = [a, b, c].into_iter().fold(0, |hash, &word| mix(hash, word).rotate_left(29));
    ((hash >> 7) % of.max(1) as u64) as usize
}

fn words([a, b, c]: &Item) -> [u64; 2] {
    [u64::from(*a) << 32 | u64::from(*b), u64::from(*c)]
}

/// The items that a part asks for.
fn items_of(part: usize, words: &[u64]) -> Result<Vec<Item>, BorderError> {
    let rows = words.chunks_exact(2);
    let length = words.len();
    if !rows.remainder().is_empty() {
        let what = "the words end within an item";
        return Err(BorderError { part, at: length, length, what });
    }
    Ok(rows.map(|row| triple(row[0], row[1])).collect())
}

/// The different values, ascending.
fn different(mut values: Vec<i64>) -> Vec<i64> {
    values.sort_unstable();
    values.dedup();
    values
}
