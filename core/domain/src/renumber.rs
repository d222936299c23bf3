//! Reports in the numbers of the input.

use crate::exterior::LEFT_OUT;
use crate::{DomainReport, Element};

/// Gives the elements of a report the numbers that they have in the input.
pub(crate) fn in_numbers_of_input(
    report: &mut DomainReport,
    vertex_map: &[u32],
    facet_map: &[u32],
) {
    let kept = || (0..).zip(vertex_map).filter(|&(_, &number)| number != LEFT_OUT);
    let count = kept().map(|(_, &v)| v as usize + 1).max().unwrap_or(0);
    let mut vertices = vec![u32::MAX; count];
    for (v, &number) in kept() {
        let first = &mut vertices[number as usize];
        *first = v.min(*first);
    }
    let vertex = |v: u32| vertices.get(v as usize).copied().unwrap_or(v);
    let facet = |f: u32| facet_map.get(f as usize).copied().unwrap_or(f);
    rename(report, &vertex, &facet);
}

/// Gives the elements of a report other numbers.
pub(crate) fn rename(
    report: &mut DomainReport,
    vertex: &dyn Fn(u32) -> u32,
    facet: &dyn Fn(u32) -> u32,
) {
    let rename = |element: &mut Element| match element {
        Element::Vertex(v) => *v = vertex(*v),
        Element::Edge(ends) => *ends = ends.map(vertex),
        Element::Facet(f)
        | Element::Polygon { facet: f, .. }
        | Element::FacetHole { facet: f, .. } => {
            *f = facet(*f);
        }
        Element::Point(_) | Element::Segment(_) | Element::Hole(_) | Element::Region(_) => {}
    };
    let firsts = report.troubles.iter_mut().filter_map(|t| t.first.as_mut());
    let defects = report.defects.iter_mut().chain(firsts);
    defects.flat_map(|d| &mut d.elements).for_each(rename);
    for trouble in &mut report.troubles {
        trouble.facets.iter_mut().for_each(|f| *f = facet(*f));
        trouble.facets.sort_unstable();
        trouble.facets.dedup();
    }
    report.inward.iter_mut().for_each(|f| *f = facet(*f));
}

/// The numbers below `count` that are not in an ascending list.
pub(crate) fn others(list: &[u32], count: usize) -> Vec<u32> {
    (0..count as u32).filter(|v| list.binary_search(v).is_err()).collect()
}
