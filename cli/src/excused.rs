//! The tetrahedra that are excused: in the report and for people, by corner and segment.

use crate::console;
use crate::remedy::{remedies, rounded_up, vertices};
use ltbw::Point;
use ltbw::domain::Prepared;
use ltbw::refine::{Excused, ExcusedShare, Reason, Refined};
use serde_json::{Value, json};

/// Corners and segments that the report lists.
const LISTED: usize = 100;
/// Reasons that people are shown.
const SHOWN: usize = 5;

/// The sum over the excused that `is` chooses: places, tetrahedra, volume.
fn sum(all: &[Excused], is: impl Fn(&Reason) -> bool) -> (usize, usize, f64) {
    let chosen = all.iter().filter(|e| is(&e.reason));
    chosen.fold((0, 0, 0.0), |(n, tets, volume), e| (n + 1, tets + e.tets, volume + e.volume))
}

/// At corners, at segments, and elsewhere.
fn sums(all: &[Excused]) -> [(usize, usize, f64); 3] {
    let elsewhere = |reason: &Reason| !reason.is_corner() && !reason.is_segment();
    [sum(all, Reason::is_corner), sum(all, Reason::is_segment), sum(all, elsewhere)]
}

/// The excused for the report.
pub(crate) fn json(all: &[Excused], share: ExcusedShare) -> Value {
    let of = |(places, tets, volume)| json!({ "places": places, "tets": tets, "volume": volume });
    let each = |e: &Excused| {
        json!({
            "reason": e.reason.to_string(),
            "reason_at": e.reason.at(),
            "tets": e.tets,
            "volume": e.volume,
            "at": e.at,
        })
    };
    let [corners, segments, elsewhere] = sums(all).map(of);
    json!({
        "corners": corners,
        "segments": segments,
        "elsewhere": elsewhere,
        "share": share.volume,
        "share_of_tets": share.tets,
        "by_reason": all.iter().take(LISTED).map(each).collect::<Vec<_>>(),
    })
}

/// A sliver that is left.
pub(crate) struct SliverLeft {
    /// Its smallest dihedral angle in degrees.
    pub(crate) angle: f64,
    /// Its centroid, in the coordinates of the mesh.
    pub(crate) at: Point,
    pub(crate) near: Option<Reason>,
}

/// The slivers that are left, the flattest first.
pub(crate) struct SliversLeft {
    /// The degrees below which they are some.
    below: f64,
    all: Vec<SliverLeft>,
}

impl SliversLeft {
    pub(crate) fn new(below: f64, mut all: Vec<SliverLeft>) -> Self {
        all.sort_by(|a, b| a.angle.total_cmp(&b.angle));
        Self { below, all }
    }

    pub(crate) fn of(refined: &Refined) -> Self {
        let all = refined.slivers.iter().map(|own| SliverLeft {
            angle: own.angle,
            at: refined.centroid(own.tet),
            near: own.near,
        });
        Self::new(refined.stats.min_dihedral, all.collect())
    }

    /// For the report.
    pub(crate) fn json(&self) -> Value {
        let each = |own: &SliverLeft| {
            json!({
                "angle": own.angle,
                "at": own.at,
                "near": own.near.map(|reason| reason.to_string()),
            })
        };
        json!({
            "below": self.below,
            "tets": self.all.len(),
            "flattest": self.all.iter().take(LISTED).map(each).collect::<Vec<_>>(),
        })
    }

    /// Tells people, as what is wrong with the mesh if nothing else is.
    pub(crate) fn print(&self, ready: &Prepared, are_all: bool) {
        let word = if are_all { "ltbw: flat" } else { "note" };
        self.text(ready).iter().for_each(|text| console::people(&format!("{word}: {text}")));
    }

    /// For people: their number, and where the flattest is; `None` of none.
    fn text(&self, ready: &Prepared) -> Option<String> {
        let first = self.all.first()?;
        let forced = self.all.iter().filter(|own| own.near.is_some()).count();
        let forced = match forced {
            0 => String::new(),
            _ => format!(", {forced} of them at small angles of the domain"),
        };
        let near = first.near.map_or(String::new(), |reason| format!(": {reason}"));
        Some(format!(
            "{} tetrahedra have a dihedral angle below {} degrees{forced}; the least is {} near \
             {}{near}",
            self.all.len(),
            self.below,
            short(first.angle, 3),
            told(ready, first.at)
        ))
    }
}

/// The excused for people: how many where, the first reasons with their places, and what would help
/// where the share is over `limit`.
pub(crate) fn text(
    refined: &Refined,
    ready: &Prepared,
    radius_edge: Option<f64>,
    limit: f64,
) -> String {
    let (all, share) = (refined.excused(), refined.excused_share());
    let [corners, segments, elsewhere] = sums(&all);
    let told = |(places, tets, volume): (usize, usize, f64), name: &str| {
        let place = match places {
            0 => return None,
            _ if name.is_empty() => "elsewhere".to_owned(),
            1 => format!("at 1 {name}"),
            _ => format!("at {places} {name}s"),
        };
        Some(format!("{tets} {place} of volume {volume:.3e}"))
    };
    let places = [told(corners, "corner"), told(segments, "segment"), told(elsewhere, "")];
    let places: Vec<String> = places.into_iter().flatten().collect();
    let first = &all[..all.len().min(SHOWN)];
    let reasons: Vec<String> =
        first.iter().map(|e| format!("{} for {}{}", e.tets, e.reason, place(ready, e))).collect();
    let more = all.len() - first.len();
    let more = if more > 0 { format!(", and {more} more reasons") } else { String::new() };
    let mut help = remedies(refined, ready, first, radius_edge);
    let least = rounded_up(share.largest());
    if !share.is_within(limit) && least <= ExcusedShare::LARGEST {
        help.push(format!("--excused-share {least} lets it pass"));
    }
    let help = if help.is_empty() { String::new() } else { format!(". {}", help.join("; ")) };
    format!(
        "{} tetrahedra over a bound, {}, {} % of all and {} % of their volume: \
         {}{more}{help}",
        refined.excuses.len(),
        places.join(", "),
        short(100.0 * share.tets, 3),
        short(100.0 * share.volume, 3),
        reasons.join(", ")
    )
}

/// The place of excused tetrahedra, in the coordinates of the input: that of the corners that are
/// the reason, else that of the largest of them.
fn place(ready: &Prepared, excused: &Excused) -> String {
    let corners = vertices(&excused.reason);
    let corners = corners.iter().filter_map(|&v| ready.domain.vertices.get(v as usize));
    let corners: Vec<String> = corners.map(|p| told(ready, *p)).collect();
    match corners.is_empty() {
        true => format!(" near {}", told(ready, excused.at)),
        false => format!(" at {}", corners.join(" ")),
    }
}

/// A place in the coordinates of the input.
fn told(ready: &Prepared, p: Point) -> String {
    let offset = ready.lattice.offset();
    let [x, y, z] = [0, 1, 2].map(|k| short(p[k] + offset[k], 6));
    format!("({x}, {y}, {z})")
}

/// A number with the given number of digits, at least one.
fn short(x: f64, digits: usize) -> f64 {
    format!("{x:.0$e}", digits - 1).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::json;
    use ltbw::domain::PrepareOptions;
    use ltbw::refine::Refiner;
    use ltbw_generate::layers::stack;

    /// Items of thin layers displace each other, and here they are never split together.
    #[test]
    fn a_reason_tells_its_place_in_numbers() {
        let thicknesses = [42.0, 6.0, 4.0].map(|t| t / 64.0);
        let domain = stack([3.0, 2.0], &thicknesses, false);
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let refiner = Refiner::new().max_volume(1e-3).joint_most(1);
        let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        let excused = json(&refined.excused(), refined.excused_share());
        let all = excused["by_reason"].as_array().expect("reasons");
        let mut places = 0;
        for own in all {
            let reason = own["reason"].as_str().expect("a text");
            let Some(at) = own["reason_at"].as_array() else {
                assert!(own["reason_at"].is_null() && !reason.contains('('), "{own}");
                continue;
            };
            let at: Vec<f64> = at.iter().filter_map(|c| c.as_f64()).collect();
            assert!(reason.ends_with(&format!("({}, {}, {})", at[0], at[1], at[2])), "{own}");
            assert!(at.iter().zip([3.0, 2.0, 1.0]).all(|(c, most)| (0.0..=most).contains(c)));
            places += 1;
        }
        assert!(places > 0, "{excused}");
    }
}
