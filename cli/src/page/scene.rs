//! A mesh as the page's script takes it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use ltbw::io::GroupName;
use ltbw::{Point, TetMesh, order};
use serde_json::json;
use std::collections::{BTreeMap, HashSet};
use std::io::Write as _;

/// The most tetrahedra in a page; of larger meshes the boundary and a slab are.
const MOST: usize = 300_000;

/// The most tetrahedra over a bound whose reasons are told.
const TOLD: usize = 10_000;

/// A mesh and what its tetrahedra and faces belong to.
pub(crate) struct Scene<'a> {
    /// The mesh, with its regions as tags and its boundary faces.
    pub(crate) mesh: &'a TetMesh,
    /// Corners of the hull's facets; what is shown in part shows their tetrahedra.
    pub(crate) hull: &'a [[u32; 3]],
    /// The worker that each tetrahedron belongs to; empty if there was one.
    pub(crate) workers: &'a [u32],
    /// The names of groups.
    pub(crate) names: &'a [GroupName],
    /// Tetrahedra over a bound, each with the reason.
    pub(crate) excused: &'a [(u32, String)],
}

/// A scene as a page has it.
pub(crate) struct Encoded {
    /// The head as JSON.
    pub(crate) head: String,
    /// Columns of 32-bit numbers, deflated, in base 64.
    pub(crate) data: String,
}

/// A tetrahedron by the places of its vertices, ascending.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Placed {
    corners: [u32; 4],
    /// Its number in the mesh.
    t: u32,
}

impl Scene<'_> {
    /// The scene as a page has it.
    pub(crate) fn encode(&self) -> Encoded {
        let kept = self.kept();
        let (names, places) = self.vertices(&kept);
        let mut tets: Vec<Placed> = kept
            .iter()
            .map(|&t| {
                let mut corners = self.mesh.tets[t as usize].map(|v| places[v as usize]);
                corners.sort_unstable();
                Placed { corners, t }
            })
            .collect();
        tets.sort_unstable();
        let tags = self.mesh.tet_tags.as_deref().unwrap_or_default();
        let regions = numbered(tets.iter().filter_map(|tet| tags.get(tet.t as usize).copied()));
        let workers = numbered(self.workers.iter().map(|&w| i64::from(w)));
        let markers = numbered(self.mesh.faces.iter().map(|f| f.marker));
        let of = |table: &BTreeMap<i64, u32>, value: Option<i64>| {
            value.and_then(|v| table.get(&v).copied()).unwrap_or(0)
        };

        let mut columns = Columns::default();
        for axis in 0..3 {
            let value = |&v: &u32| (self.mesh.points[v as usize][axis] as f32).to_bits();
            columns.add(names.iter().map(value));
        }
        columns.add(names.iter().copied());
        columns.add(tets.iter().map(|tet| tet.t));
        let first = tets.iter().map(|tet| tet.corners[0]);
        let before = std::iter::once(0).chain(first.clone());
        columns.add(first.zip(before).map(|(c, b)| c - b));
        for k in 1..4 {
            columns.add(tets.iter().map(|tet| tet.corners[k] - tet.corners[k - 1]));
        }
        columns.add(tets.iter().map(|tet| of(&regions, tags.get(tet.t as usize).copied())));
        let worker = |t: u32| self.workers.get(t as usize).map(|&w| i64::from(w));
        columns.add(tets.iter().map(|tet| of(&workers, worker(tet.t))));
        columns.add(self.marked(&tets, &places, &markers).into_iter());

        let listed = |table: &BTreeMap<i64, u32>| {
            let mut list: Vec<(u32, i64)> = table.iter().map(|(&v, &k)| (k, v)).collect();
            list.sort_unstable();
            list.into_iter().map(|(_, v)| v.to_string()).collect::<Vec<_>>()
        };
        let named = |&marker: &i64| {
            let own = self.names.iter().find(|n| n.dimension == 2 && n.group == marker);
            own.map(|own| own.name.as_str())
        };
        let kept: HashSet<u32> = tets.iter().map(|tet| tet.t).collect();
        let reasons = self.excused.iter().filter(|(t, _)| kept.contains(t));
        let excused: BTreeMap<String, &str> =
            reasons.take(TOLD).map(|(t, reason)| (t.to_string(), reason.as_str())).collect();
        let head = json!({
            "points": names.len(),
            "tets": tets.len(),
            "total": self.mesh.tets.len(),
            "regions": listed(&regions),
            "markers": listed(&markers),
            "names": markers.keys().map(named).collect::<Vec<_>>(),
            "excused": excused,
            "workers": listed(&workers),
        });
        let head = head.to_string().replace('<', "\\u003c");
        Encoded { head, data: columns.packed() }
    }

    /// The tetrahedra in the page: all, or those at the boundary and in a slab across the z axis,
    /// as thick as there is room for.
    fn kept(&self) -> Vec<u32> {
        let all = &self.mesh.tets;
        if all.len() <= MOST {
            return (0..all.len() as u32).collect();
        }
        let mut is_kept = vec![false; all.len()];
        self.mesh.faces.iter().filter(|f| f.tet < all.len()).for_each(|f| is_kept[f.tet] = true);
        self.at_the_hull().for_each(|t| is_kept[t] = true);
        let mut outer = is_kept.iter().filter(|&&kept| kept).count();
        // A boundary with no room for anything else is left out.
        if outer > MOST / 2 {
            is_kept.fill(false);
            outer = 0;
        }
        let height =
            |t: usize| all[t].iter().map(|&v| self.mesh.points[v as usize][2]).sum::<f64>();
        let heights: Vec<f64> = (0..all.len()).map(height).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let middle = (low + high) / 2.0;
        let mut inner: Vec<usize> = (0..all.len()).filter(|&t| !is_kept[t]).collect();
        let far = |t: &usize| (heights[*t] - middle).abs();
        inner.sort_by(|a, b| far(a).total_cmp(&far(b)));
        inner.iter().take(MOST - outer).for_each(|&t| is_kept[t] = true);
        (0..all.len() as u32).filter(|&t| is_kept[t as usize]).collect()
    }

    /// The tetrahedra that have a facet of the hull.
    fn at_the_hull(&self) -> impl Iterator<Item = usize> {
        let sorted = |mut corners: [u32; 3]| {
            corners.sort_unstable();
            corners
        };
        let facets: HashSet<[u32; 3]> = self.hull.iter().map(|&f| sorted(f)).collect();
        let corners: HashSet<u32> = facets.iter().flatten().copied().collect();
        self.mesh.tets.iter().enumerate().filter_map(move |(t, tet)| {
            // Few tetrahedra have three corners there.
            let outer = tet.iter().filter(|v| corners.contains(v)).count() > 2;
            let [a, b, c, d] = *tet;
            let faces = [[b, c, d], [a, c, d], [a, b, d], [a, b, c]];
            (outer && faces.into_iter().any(|f| facets.contains(&sorted(f)))).then_some(t)
        })
    }

    /// The vertices in use, along a Hilbert curve, and the place of each in that list.
    fn vertices(&self, kept: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let mut places = vec![u32::MAX; self.mesh.points.len()];
        for &v in kept.iter().flat_map(|&t| &self.mesh.tets[t as usize]) {
            places[v as usize] = 0;
        }
        let used: Vec<u32> =
            (0..places.len() as u32).filter(|&v| places[v as usize] == 0).collect();
        let points: Vec<Point> = used.iter().map(|&v| self.mesh.points[v as usize]).collect();
        let names: Vec<u32> =
            order::hilbert(&points).into_iter().map(|k| used[k as usize]).collect();
        for (place, &v) in names.iter().enumerate() {
            places[v as usize] = place as u32;
        }
        (names, places)
    }

    /// For the face opposite to each corner the number of its marker from 1 on; 0 for none.
    fn marked(&self, tets: &[Placed], places: &[u32], markers: &BTreeMap<i64, u32>) -> Vec<u32> {
        let mut marked = vec![0; 4 * tets.len()];
        let mut by_tet: Vec<(u32, u32)> =
            tets.iter().enumerate().map(|(i, tet)| (tet.t, i as u32)).collect();
        by_tet.sort_unstable();
        for face in &self.mesh.faces {
            let Ok(found) = by_tet.binary_search_by_key(&face.tet, |&(t, _)| t as usize) else {
                continue;
            };
            let place = by_tet[found].1 as usize;
            let corners = face.corners.map(|v| places[v as usize]);
            let number = markers.get(&face.marker).map_or(0, |k| k + 1);
            if let Some(slot) = tets[place].corners.iter().position(|c| !corners.contains(c)) {
                marked[4 * place + slot] = number;
            }
        }
        marked
    }
}

/// Numbers from 0 on for the different values, in ascending order.
fn numbered(values: impl Iterator<Item = i64>) -> BTreeMap<i64, u32> {
    let mut table: BTreeMap<i64, u32> = values.map(|v| (v, 0)).collect();
    (0..).zip(table.values_mut()).for_each(|(k, number)| *number = k);
    table
}

/// Columns of 32-bit numbers, each as four planes of bytes, lowest first: what is alike lies
/// together, which deflates well.
#[derive(Default)]
struct Columns(Vec<u8>);

impl Columns {
    fn add(&mut self, column: impl Iterator<Item = u32> + Clone) {
        for shift in [0, 8, 16, 24] {
            self.0.extend(column.clone().map(|word| (word >> shift) as u8));
        }
    }

    fn packed(&self) -> String {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        // Writing to memory cannot fail.
        let _ = encoder.write_all(&self.0);
        STANDARD.encode(encoder.finish().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::ZlibDecoder;
    use ltbw::BoundaryFace;
    use std::io::Read as _;

    /// The columns of data whose lengths are given.
    fn columns(data: &str, lengths: &[usize]) -> Vec<Vec<u32>> {
        let packed = STANDARD.decode(data).expect("base 64");
        let mut bytes = Vec::new();
        ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).expect("zlib");
        assert_eq!(bytes.len(), 4 * lengths.iter().sum::<usize>());
        let mut rest = &bytes[..];
        let mut column = |&count: &usize| {
            let (planes, behind) = rest.split_at(4 * count);
            rest = behind;
            let byte = |k: usize, i: usize| u32::from(planes[k * count + i]) << (8 * k);
            (0..count).map(|i| (0..4).map(|k| byte(k, i)).sum()).collect()
        };
        lengths.iter().map(&mut column).collect()
    }

    #[test]
    fn two_tetrahedra_come_back() {
        let points = vec![
            [9.0, 9.0, 9.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
        ];
        let tets = vec![[1, 2, 3, 4], [5, 4, 3, 2]];
        let faces = vec![BoundaryFace { corners: [2, 3, 5], marker: 40, tet: 1 }];
        let tet_tags = Some(vec![7, -2]);
        let mesh = TetMesh { points, tets, tet_tags, faces, ..TetMesh::default() };
        let Encoded { head, data } =
            Scene { mesh: &mesh, hull: &[], workers: &[3, 1], names: &[], excused: &[] }.encode();
        let head: serde_json::Value = serde_json::from_str(&head).expect("JSON");
        assert_eq!(head["points"], 5, "the first point is not in use");
        assert_eq!(head["regions"], json!(["-2", "7"]));
        assert_eq!((&head["markers"], &head["workers"]), (&json!(["40"]), &json!(["1", "3"])));
        let found = columns(&data, &[5, 5, 5, 5, 2, 2, 2, 2, 2, 2, 2, 8]);
        let (names, numbers) = (&found[3], &found[4]);
        for (place, &v) in names.iter().enumerate() {
            let point = [0, 1, 2].map(|k| f64::from(f32::from_bits(found[k][place])));
            assert_eq!(point, mesh.points[v as usize]);
        }
        let mut first = 0;
        for (i, &t) in numbers.iter().enumerate() {
            first += found[5][i];
            let mut corner = first;
            let mut corners = vec![names[corner as usize]];
            for step in &found[6..9] {
                corner += step[i];
                corners.push(names[corner as usize]);
            }
            let marked: Vec<u32> = found[11][4 * i..4 * i + 4].to_vec();
            let opposite = corners.iter().zip(&marked).find(|(_, m)| **m > 0).map(|(&c, _)| c);
            assert_eq!(opposite, (t == 1).then_some(4), "the face 2 3 5 has a marker");
            corners.sort_unstable();
            let mut own = mesh.tets[t as usize].to_vec();
            own.sort_unstable();
            assert_eq!(corners, own);
            assert_eq!((found[9][i], found[10][i]), if t == 0 { (1, 1) } else { (0, 0) });
        }
    }

    #[test]
    fn large_meshes_are_shown_in_part() {
        let count = MOST + 1000;
        let height = |v: usize| f64::from(v as u32) / count as f64;
        let points = (0..count).flat_map(|v| {
            let z = height(v);
            [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z], [0.0, 0.0, z + 0.5]]
        });
        let tets = (0..count as u32).map(|t| [4 * t, 4 * t + 1, 4 * t + 2, 4 * t + 3]).collect();
        let faces = vec![BoundaryFace { corners: [0, 1, 2], marker: 1, tet: 0 }];
        let mut mesh = TetMesh { points: points.collect(), tets, faces, ..TetMesh::default() };
        let scene = Scene { mesh: &mesh, hull: &[], workers: &[], names: &[], excused: &[] };
        let kept = scene.kept();
        assert_eq!(kept.len(), MOST);
        assert_eq!((kept[0], kept[1]), (0, 501), "the boundary, and the slab in the middle");
        // Facets of the hull in whatever order of corners; one that no tetrahedron has.
        let last = 4 * (count as u32 - 1);
        let hull = [[last + 2, last + 1, last + 3], [4, 7, 5], [8, 9, 12]];
        mesh.faces.clear();
        let kept =
            Scene { mesh: &mesh, hull: &hull, workers: &[], names: &[], excused: &[] }.kept();
        assert_eq!(kept.len(), MOST);
        assert_eq!((kept[0], kept[1]), (1, 501), "a facet of the hull, and the slab");
        assert_eq!((kept[MOST - 2], kept[MOST - 1]), (count as u32 - 502, count as u32 - 1));
    }
}
