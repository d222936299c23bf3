//! The conformity of a mesh in parts: each member of a team has one, and the whole domain.
//!
//! The inside of a part is looked at there, by the code for whole meshes. Whatever is between
//! parts is looked at where it meets: vertices and faces by their coordinates, as in
//! [`crate::check_parted`]; the pieces of an edge of the domain by the number of that edge. Areas
//! of planes and volumes are sums, exact ones; components of the mesh are put together at the
//! faces between parts that are on no facet.
//!
//! | module | what it holds |
//! |---|---|
//! | `chains` | edges of the domain are chains of edges of the mesh |
//! | `between` | faces between parts, and of the hull: tiles, tags, components |
//! | `tiled` | the tiles of patches: areas, turns, and edges of an odd number of them |
//! | `sums` | areas, volumes, findings, small angles of all members |
//!
//! A face between parts is on a patch by the tags on both its sides, which meet with it. An edge of
//! an odd number of a part's tiles meets those of other parts, and the edges of the mesh on edges
//! of the domain, by its ends.

mod between;
mod chains;
mod sums;
mod tiled;

use super::exterior::Exterior;
use super::patches::{InUnits, Names, Patches};
use super::tiles::{Planes, planes_of};
use super::tree::Tree;
use super::whole::{Units, Whole};
use super::{Conformity, ConformityDefect, Limits, Plc, Regions, Run};
use crate::mesh::{Mesh, Options, Point};
use crate::parted::exchange::{Exchange, before, tell_all, tell_all_bytes};
use crate::parted::{self, Part, Soundness};
use between::Between;
use std::collections::HashSet;

/// A member's part of a mesh of a domain. Nothing about it is trusted.
#[derive(Debug, Clone, Copy)]
pub struct DomainPart<'a> {
    /// Coordinates of the part's vertices.
    pub points: &'a [Point],
    /// Their numbers in the whole mesh, one for each.
    pub numbers: &'a [u32],
    /// The part's tetrahedra: four indices into `points` each.
    pub tets: &'a [[u32; 4]],
    /// The regions of the tetrahedra, if those of all members are known.
    pub tags: Option<&'a [i64]>,
}

/// Checks a mesh whose parts the members of a team have against the domain that it is to be a mesh
/// of, as [`conforms`](super::conforms) does; all get the same findings. All have the same domain
/// and limits. Never panics, whatever the parts and the domain.
///
/// Tetrahedra have their numbers in the lists of all members, one after the other, and vertices of
/// the mesh those of [`DomainPart::numbers`].
///
/// # Errors
/// Those of the team; what makes no sense is [`Exchange::nonsense`].
pub fn conforms_parted<E: Exchange>(
    team: &mut E,
    part: &DomainPart<'_>,
    plc: &Plc,
    limits: &Limits,
    options: &Options,
) -> Result<Conformity, E::Error> {
    let DomainPart { points, numbers, tets, tags } = *part;
    let tags = tags.filter(|tags| tags.len() == tets.len());
    let lacks = tell_all(team, &[u32::from(tags.is_none())])?;
    let tags = tags.filter(|_| lacks.iter().flatten().all(|&lacks| lacks == 0));
    let whole = Part { points, numbers, tets, given: &[] };
    let sound = parted::soundness(team, &whole, tags, options)?;
    let mut out = Conformity {
        mesh_defects: sound.defects.clone(),
        mesh_defect_count: sound.count,
        tests: sound.tests,
        parts: Some(team.members() as u64),
        ..Conformity::default()
    };
    if sound.count > 0 {
        return Ok(out);
    }
    let named = plc.facets.iter().flat_map(|f| &f.polygons).flatten().copied();
    let named = named.chain(plc.segments.iter().flatten().copied());
    let is_known = named.into_iter().all(|v| (v as usize) < plc.vertices.len());
    let units = match is_known {
        true => units(team, points, plc)?,
        false => None,
    };
    let Some(units) = units else {
        out.counts.insert(ConformityDefect::TooFine, 1);
        let finding = super::Finding { breach: ConformityDefect::TooFine, ids: Vec::new() };
        out.findings.push(finding);
        return Ok(out);
    };
    let mesh = Mesh::new(points, tets);
    let whole: Vec<Whole> = points.iter().map(|p| units.whole(p)).collect();
    let (exterior, limit) = (Exterior::default(), options.max_defects);
    let mut run = Run { mesh: &mesh, plc, exterior, limit, out };
    let present = present(team, &run.present(&units, &whole))?;
    let left: Plc;
    if let Some(exterior) = Exterior::find(plc, &units, &present) {
        left = exterior.left(plc);
        (run.plc, run.exterior) = (&left, exterior);
    }
    if team.me() == 0 {
        run.vertices(&present);
    }
    let judged = Judged { units, points: &whole, numbers, sound: &sound };
    let regions = run.places_in_parts(team, &judged, tags)?;
    let cells = Regions { cells: &regions.cells, seeds: &regions.seeds };
    run.numbers(cells, tags.filter(|_| options.numbered_regions));
    let volume = sums::volume(team, &run.six_volumes(&whole))?;
    run.bounds(&units, &whole, limits, cells, &regions.on_patches);
    run.out.tets = sound.tets;
    let mut out = sums::findings(team, run.out, sound.first, limit)?;
    (out.cells, out.volume) = (regions.count, Some(units.sixth(&volume)));
    Ok(out)
}

/// A part as it is judged.
struct Judged<'a> {
    units: Units,
    points: &'a [Whole],
    /// The numbers of its vertices in the whole.
    numbers: &'a [u32],
    sound: &'a Soundness,
}

/// The inside of a part: which faces are on facets, and the regions.
struct Inside<'a> {
    own: &'a Judged<'a>,
    codes: &'a HashSet<u32>,
    tags: Option<&'a [i64]>,
}

/// The components of the whole mesh between facets.
struct Components {
    /// By tetrahedron of the part.
    cells: Vec<u32>,
    /// By region of the domain.
    seeds: Vec<Option<u32>>,
    count: u64,
    /// By vertex of the part the patches that it is on.
    on_patches: Vec<Vec<u32>>,
}

/// The largest unit of which the coordinates of all members are multiples.
fn units<E: Exchange>(
    team: &mut E,
    points: &[Point],
    plc: &Plc,
) -> Result<Option<Units>, E::Error> {
    let lists = [points, &plc.vertices];
    let own = Units::lowest(&lists);
    // As numbers that ascend with it.
    let told = own.map_or([1, 0], |low| [0, (low as u32) ^ 1 << 31]);
    let all: Vec<[u32; 2]> = tell_all(team, &[told])?.into_iter().flatten().collect();
    let least = all.iter().map(|own| own[1]).min().unwrap_or(0);
    let units = Units::at((least ^ 1 << 31) as i32);
    let is_unfit = all.iter().any(|own| own[0] > 0) || !units.fit_all(&lists);
    let unfit = tell_all(team, &[u32::from(is_unfit)])?;
    Ok((unfit.iter().flatten().all(|&unfit| unfit == 0)).then_some(units))
}

/// Which vertices of the domain any part has.
fn present<E: Exchange>(team: &mut E, own: &[bool]) -> Result<Vec<bool>, E::Error> {
    let byte = |eight: &[bool]| eight.iter().rev().fold(0, |byte, &own| byte << 1 | u8::from(own));
    let bytes: Vec<u8> = own.chunks(8).map(byte).collect();
    let mut present = vec![false; own.len()];
    for (from, told) in tell_all_bytes(team, &bytes)?.iter().enumerate() {
        if told.len() != bytes.len() {
            return Err(team.nonsense(from, "vertices of another domain"));
        }
        for (v, is_there) in present.iter_mut().enumerate() {
            *is_there |= told[v / 8] >> (v % 8) & 1 == 1;
        }
    }
    Ok(present)
}

impl Run<'_> {
    /// Edges and facets of the domain, the hull, and the components of the whole mesh.
    fn places_in_parts<E: Exchange>(
        &mut self,
        team: &mut E,
        own: &Judged<'_>,
        tags: Option<&[i64]>,
    ) -> Result<Components, E::Error> {
        let Judged { units, points, numbers, sound } = own;
        let corners: Vec<Whole> = self.plc.vertices.iter().map(|p| units.whole(p)).collect();
        let mut flat = self.flats(units, &corners);
        let found = Patches::find(self.plc, &corners, units);
        if team.me() == 0 {
            let none = (0u32..).zip(&flat).filter(|(_, flat)| flat.is_none());
            none.for_each(|(f, _)| self.degenerate(f));
            if found.is_none() {
                self.add(ConformityDefect::TooFine, &[]);
            }
        }
        let patches = found.unwrap_or_else(|| Patches::none(self.plc, units));
        let used = self.used();
        let order = (0..points.len() as u32).filter(|&v| used[v as usize]);
        let tree = Tree::new(points, order.collect());
        let on = self.vertices_on(&flat, &corners, &tree);
        let mut between = Between::of(&sound.met, units, self, &flat, &corners);
        let groups = patches.groups(&mut flat, &corners);
        let wanted = self.wanted(&groups);
        let chains = self.chains(&wanted, &corners, points, &tree);
        let outline = self.edges_in_parts(team, &wanted, &chains, &sound.by_place)?;
        drop((tree, chains));
        let (planes, on_planes) = (Planes::new(&flat, &groups), planes_of(&on, &groups));
        let (mut codes, mut areas) =
            self.found_tiles(&planes, points, &sound.faces, &on_planes, true);
        drop(on_planes);
        between.find_tiles(self, &groups, &planes, &mut areas);
        self.untiled(team, &planes, &areas)?;
        let on_patches = patches.at(&on, points);
        drop(on);
        let part = Names { first: sound.first, numbers, by_place: &sound.by_place };
        let mesh = InUnits { units, points, faces: &sound.faces, tags, part: Some(part) };
        let mut tiled = self.found_on_patches(&patches, &mesh, &on_patches, &mut codes);
        between.find_on_patches(&patches, units, &mut tiled);
        self.patches_in_parts(team, &patches, tiled, &outline)?;
        between.hull(self);
        let (cells, count) =
            self.components(team, Inside { own, codes: &codes, tags }, &between)?;
        let seeds = self.seeds(units, points);
        let seeds = self.seeds_in_parts(team, sound.first, &seeds, &cells)?;
        Ok(Components { cells, seeds, count, on_patches })
    }

    /// The component of each tetrahedron of the part, and their number in the whole mesh.
    fn components<E: Exchange>(
        &mut self,
        team: &mut E,
        Inside { own, codes, tags }: Inside<'_>,
        between: &Between<'_>,
    ) -> Result<(Vec<u32>, u64), E::Error> {
        let sound = own.sound;
        let before_these = self.out.findings.len();
        let mut cells = self.cells(&sound.faces, codes, tags);
        for tet in self.out.findings[before_these..].iter_mut().flat_map(|own| &mut own.ids) {
            *tet = tet.saturating_add(sound.first);
        }
        let [first, count] = before(team, self.out.cells)?;
        cells.iter_mut().for_each(|cell| *cell = cell.saturating_add(first as u32));
        let sides = between::sides(self.mesh, sound, &cells);
        let joined = between.join(self, team, sides)?;
        let roots = sums::Roots::of(count, &joined);
        cells.iter_mut().for_each(|cell| *cell = roots.root(*cell));
        Ok((cells, roots.count))
    }

    /// The component of each region, of the tetrahedra of all parts that hold holes and seeds.
    fn seeds_in_parts<E: Exchange>(
        &mut self,
        team: &mut E,
        first: u32,
        seeds: &[Option<usize>],
        cells: &[u32],
    ) -> Result<Vec<Option<u32>>, E::Error> {
        let told = |seed: &Option<usize>| {
            seed.map_or([u32::MAX; 2], |t| [first.saturating_add(t as u32), cells[t]])
        };
        let own: Vec<[u32; 2]> = seeds.iter().map(told).collect();
        let all = tell_all(team, &own)?;
        if let Some(from) = all.iter().position(|list| list.len() != seeds.len()) {
            return Err(team.nonsense(from, "regions of another domain"));
        }
        let least = |k: usize| all.iter().map(|list| list[k]).min().unwrap_or([u32::MAX; 2]);
        let found: Vec<[u32; 2]> = (0..seeds.len()).map(least).collect();
        let is_there = |own: &[u32; 2]| (own[0] != u32::MAX).then_some(own[0] as usize);
        let tets: Vec<Option<usize>> = found.iter().map(is_there).collect();
        if team.me() == 0 {
            self.regions(&tets).for_each(drop);
        }
        let of_regions = found.iter().skip(self.plc.holes.len());
        Ok(of_regions.map(|own| (own[0] != u32::MAX).then_some(own[1])).collect())
    }
}
