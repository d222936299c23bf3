//! The kinds of point sets and domains that `generate` makes.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use ltbw_generate::{DomainKind, PointKind};

/// A kind of point set or domain that `generate` makes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// A point set.
    Points(PointKind),
    /// A domain.
    Domain(DomainKind),
}

/// A parser of kinds by their names.
pub(crate) fn kinds() -> impl TypedValueParser<Value = Kind> {
    let value = |(name, about)| clap::builder::PossibleValue::new(name).help(about);
    let points = PointKind::ALL.map(|k| (k.name(), k.about())).into_iter();
    let domains = DomainKind::ALL.map(|k| (k.name(), k.about())).into_iter();
    let values = points.chain(domains).map(value);
    PossibleValuesParser::new(values).try_map(|name| {
        let domain = name.parse::<DomainKind>().map(Kind::Domain);
        domain.or_else(|_| name.parse::<PointKind>().map(Kind::Points))
    })
}
