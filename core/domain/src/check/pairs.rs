//! Every two pieces that may meet, and the contacts between them.

use super::Findings;
use super::complex::{Complex, Piece, Shape};
use super::contact::{Contact, Contacts, shared_side};
use super::parting::{self, Together};
use crate::{DefectKind, Element};
use rayon::prelude::*;
use std::collections::HashSet;

/// The number of contacts after which no more are looked for: the domain is beyond repair, and a
/// heap of overlapping triangles would have quadratically many.
const ENOUGH: usize = 20_000;

/// The most contacts that are looked for at one piece in one list.
const ENOUGH_AT_ONE: usize = 64;

/// Lists of pieces that are looked at between two looks at how many contacts there are.
const WAVE: usize = 1 << 12;

/// A contact of two pieces, the lower number first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Found {
    one: u32,
    other: u32,
    contact: Contact,
}

/// A pair of elements in contact, which is told once.
#[derive(PartialEq, Eq, Hash)]
struct Told {
    elements: [Element; 2],
    kind: DefectKind,
}

/// Finds the contacts between pieces and reports each once for every pair of elements.
pub(super) fn find(complex: &Complex<'_>, pieces: &[Piece], findings: &mut Findings) {
    let parted = parting::part(complex, pieces);
    let mut found: Vec<Found> = Vec::new();
    for wave in parted.lists.chunks(WAVE) {
        let more = wave.par_iter().flat_map_iter(|list| contacts_in(complex, pieces, list));
        found.extend(more.collect::<Vec<Found>>());
        if found.len() > ENOUGH {
            break;
        }
    }
    // Two pieces may be together in several lists.
    found.sort_unstable();
    found.dedup();
    let mut told = HashSet::new();
    for found in found {
        report(complex, found, &mut told, findings);
    }
}

/// Each piece of a list with others that are not of its facet, such that each two are met once: the
/// pieces of a facet, which follow each other, are a triangulation.
fn with_others<'a>(
    complex: &'a Complex<'_>,
    together: &'a Together,
) -> Box<dyn Iterator<Item = (u32, &'a [u32])> + 'a> {
    let list = together.list.as_slice();
    let facet = |n: &u32| complex.facet_of.get(*n as usize);
    if let Some(own) = together.own {
        let first = list.partition_point(|n| facet(n).is_some_and(|&f| f < own));
        let end = list.partition_point(|n| facet(n).is_some_and(|&f| f <= own));
        let both = [&list[..first], &list[end..]];
        let own = list[first..end].iter();
        return Box::new(own.flat_map(move |&n| both.map(|others| (n, others))));
    }
    let mut end = 0;
    let groups = list.chunk_by(move |a, b| facet(a).is_some() && facet(a) == facet(b));
    Box::new(groups.flat_map(move |group| {
        end += group.len();
        let others = &list[end..];
        group.iter().map(move |&n| (n, others))
    }))
}

/// The members of `others` whose boxes meet that of a piece.
fn near<'a>(pieces: &'a [Piece], n: u32, others: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
    let a = &pieces[n as usize];
    let meets = |b: &Piece| (0..3).all(|k| a.low[k] <= b.high[k] && b.low[k] <= a.high[k]);
    others.iter().copied().filter(move |&other| meets(&pieces[other as usize]))
}

/// The contacts between the pieces of a list.
fn contacts_in(complex: &Complex<'_>, pieces: &[Piece], together: &Together) -> Vec<Found> {
    let of = |(n, others): (u32, &[u32])| {
        let contacts = near(pieces, n, others).filter_map(|other| {
            let (one, other) = (n.min(other), n.max(other));
            Some(Found { one, other, contact: contact(complex, one, other)? })
        });
        contacts.take(ENOUGH_AT_ONE).collect::<Vec<Found>>()
    };
    with_others(complex, together).flat_map(of).collect()
}

/// The number of pairs in all lists that are compared.
#[cfg(test)]
pub(super) fn compared(complex: &Complex<'_>, lists: &[Together]) -> u64 {
    let all = lists.iter().flat_map(|list| with_others(complex, list));
    all.map(|(_, others)| others.len() as u64).sum()
}

/// The contact of two pieces, if there is one.
pub(super) fn contact(complex: &Complex<'_>, number: u32, other: u32) -> Option<Contact> {
    let contacts = Contacts { points: complex.points };
    // The pieces of a facet are a triangulation.
    let (a, b) = (complex.element(number), complex.element(other));
    if a == b && matches!(a, Element::Facet(_)) {
        return None;
    }
    match (complex.shape(number), complex.shape(other)) {
        (Shape::Triangle(t), Shape::Triangle(u)) => contacts.triangles(t, u).or_else(|| {
            let shared = shared_side(t, u)?;
            let drawn = complex.draws(number, shared) && complex.draws(other, shared);
            (!drawn).then_some(Contact::Crossing)
        }),
        // An edge along a side that a facet does not draw lies inside the facet.
        (Shape::Triangle(t), Shape::Edge(e)) if e.iter().all(|v| t.contains(v)) => {
            (!complex.draws(number, e)).then_some(Contact::Crossing)
        }
        (Shape::Triangle(t), Shape::Edge(e)) => contacts.edge_on_triangle(e, t),
        (Shape::Edge(e), Shape::Edge(f)) => contacts.edges(e, f),
        // The rest is in the other order.
        _ => None,
    }
}

fn report(complex: &Complex<'_>, found: Found, told: &mut HashSet<Told>, findings: &mut Findings) {
    let Found { one, other, contact } = found;
    let (a, b) = (complex.element(one), complex.element(other));
    let kind = match contact {
        Contact::Crossing => DefectKind::Intersection,
        Contact::Overlap => DefectKind::Overlap,
        Contact::Touch(_) => DefectKind::TJunction,
    };
    // A vertex on many triangles of one facet is one finding, at one vertex.
    let mut elements = vec![a, b];
    let mut pair = [a.min(b), a.max(b)];
    if let Contact::Touch(v) = contact {
        let vertex = Element::Vertex(v);
        let names = |n: u32| match complex.shape(n) {
            Shape::Triangle(t) => t.contains(&v),
            Shape::Edge(e) => e.contains(&v),
        };
        let touched = if names(one) { b } else { a };
        elements = vec![vertex, touched];
        pair = [vertex, touched];
    }
    if !told.insert(Told { elements: pair, kind }) {
        return;
    }
    let point = |v: u32| complex.points[v as usize];
    let corners = |n: u32| match complex.shape(n) {
        Shape::Triangle(t) => t.map(point).to_vec(),
        Shape::Edge(e) => e.map(point).to_vec(),
    };
    let at = match contact {
        Contact::Touch(v) => vec![point(v)],
        _ => [corners(one), corners(other)].concat(),
    };
    findings.add(kind, elements, at);
}
