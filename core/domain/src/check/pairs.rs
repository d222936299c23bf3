//! Every two pieces whose boxes meet, and the contacts between them.

use super::Findings;
use super::complex::{Complex, Piece, Shape};
use super::contact::{Contact, Contacts, shared_side};
use crate::{DefectKind, Element};
use rayon::prelude::*;
use rstar::RTree;
use rstar::RTreeObject;
use std::collections::HashSet;

/// The number of contacts after which no more are looked for: the domain is beyond repair, and a
/// heap of overlapping triangles would have quadratically many.
const ENOUGH: usize = 20_000;

/// The most contacts that are looked for at one piece.
const ENOUGH_AT_ONE: usize = 64;

/// Pieces that are looked at between two looks at how many contacts there are.
const WAVE: u32 = 1 << 14;

/// Finds the contacts between pieces and reports each once for every pair of elements.
pub(super) fn find(complex: &Complex<'_>, index: &RTree<Piece>, findings: &mut Findings) {
    let mut seen: HashSet<(Element, Element, DefectKind)> = HashSet::new();
    let count = complex.count() as u32;
    for start in (0..count).step_by(WAVE as usize) {
        let end = count.min(start.saturating_add(WAVE));
        let found: Vec<(u32, u32, Contact)> = (start..end)
            .into_par_iter()
            .flat_map_iter(|n| contacts_of(complex, index, n).into_iter().take(ENOUGH_AT_ONE))
            .collect();
        for (one, other, contact) in found {
            report(complex, one, other, contact, &mut seen, findings);
        }
        if seen.len() > ENOUGH {
            return;
        }
    }
}

/// The contacts of a piece with those of higher numbers.
fn contacts_of(
    complex: &Complex<'_>,
    index: &RTree<Piece>,
    number: u32,
) -> Vec<(u32, u32, Contact)> {
    let contacts = Contacts { points: complex.points };
    let piece = complex.piece(number);
    let mut found = Vec::new();
    for other in index.locate_in_envelope_intersecting(piece.envelope()) {
        let other = other.number;
        if other <= number {
            continue;
        }
        // The pieces of a facet are a triangulation.
        let (a, b) = (complex.element(number), complex.element(other));
        if a == b && matches!(a, Element::Facet(_)) {
            continue;
        }
        let contact = match (complex.shape(number), complex.shape(other)) {
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
            (Shape::Triangle(t), Shape::Vertex(v)) => contacts.vertex_on_triangle(v, t),
            (Shape::Edge(e), Shape::Edge(f)) => contacts.edges(e, f),
            (Shape::Edge(e), Shape::Vertex(v)) => {
                contacts.on_edge(e, v).then_some(Contact::Touch(v))
            }
            // The rest are vertices, which are distinct, or in the other order.
            _ => None,
        };
        if let Some(contact) = contact {
            found.push((number, other, contact));
            if found.len() >= ENOUGH_AT_ONE {
                break;
            }
        }
    }
    found
}

fn report(
    complex: &Complex<'_>,
    one: u32,
    other: u32,
    contact: Contact,
    seen: &mut HashSet<(Element, Element, DefectKind)>,
    findings: &mut Findings,
) {
    let (a, b) = (complex.element(one), complex.element(other));
    let kind = match contact {
        Contact::Crossing => DefectKind::Intersection,
        Contact::Overlap => DefectKind::Overlap,
        Contact::Touch(_) => DefectKind::TJunction,
    };
    // A vertex on many triangles of one facet is one finding, at one vertex.
    let mut elements = vec![a, b];
    let mut key = (a.min(b), a.max(b));
    if let Contact::Touch(v) = contact {
        let vertex = Element::Vertex(v);
        let names = |n: u32| match complex.shape(n) {
            Shape::Triangle(t) => t.contains(&v),
            Shape::Edge(e) => e.contains(&v),
            Shape::Vertex(w) => w == v,
        };
        let touched = if names(one) { b } else { a };
        elements = vec![vertex, touched];
        key = (vertex, touched);
    }
    if !seen.insert((key.0, key.1, kind)) {
        return;
    }
    let point = |v: u32| complex.points[v as usize];
    let corners = |n: u32| match complex.shape(n) {
        Shape::Triangle(t) => t.map(point).to_vec(),
        Shape::Edge(e) => e.map(point).to_vec(),
        Shape::Vertex(v) => vec![point(v)],
    };
    let at = match contact {
        Contact::Touch(v) => vec![point(v)],
        _ => [corners(one), corners(other)].concat(),
    };
    findings.add(kind, elements, at);
}
