//! The other processes of a job, as the pipeline sees them: `ranks` has those of `ltbw-mpi`.

use crate::outcome::Failure;

/// The processes, as the pipeline sees them.
pub(crate) trait Ranks {
    /// Their number.
    fn size(&self) -> u32;

    /// Makes sure that all have read an input with this fingerprint.
    fn agree(&self, fingerprint: String) -> Result<(), Failure>;

    /// The processes as those none of which has all of the mesh.
    #[cfg(feature = "wire")]
    fn apart(&self) -> &dyn Apart;
}

/// The processes of a run, if there are several.
pub(crate) type Others<'r> = Option<&'r dyn Ranks>;

#[cfg(feature = "wire")]
pub(crate) use apart::{Apart, Work};

/// The word of a process, for people: the first one needs no name.
#[cfg(feature = "wire")]
pub(crate) fn of_rank(rank: u32, why: &str) -> String {
    match rank {
        0 => why.to_owned(),
        _ => format!("rank {rank}: {why}"),
    }
}

#[cfg(feature = "wire")]
mod apart {
    use super::of_rank;
    use crate::outcome::Failure;
    use crate::workers::{Made, Mode};
    use ltbw::distributed::{Gathered, Hashed, Joined, Part, Points, Slice, SliceError};
    use ltbw::domain::{Prepared, Thickness};
    use ltbw::io::{Border, Piece};
    use ltbw::protocol::WorkerId;
    use ltbw::refine::{Refined, Refiner};
    use ltbw::refining::{RefineError, TeamEnd, Wishes};
    use ltbw::threads::{BuiltPart, Parallel, RunError};
    use ltbw::wire::{bytes_of, value_of};
    use ltbw::{Builder, CancelToken, Point};
    use ltbw_verify as verify;
    use serde::Serialize;
    use serde::de::DeserializeOwned;

    /// The workers of a job, what stops them, and how they refine.
    #[derive(Clone, Copy)]
    pub(crate) struct Work<'w> {
        pub(crate) parallel: &'w Parallel<'w>,
        pub(crate) token: &'w CancelToken,
        pub(crate) mode: Mode,
    }

    /// Processes each of which has a slice of the points, and a part of the mesh.
    pub(crate) trait Apart {
        /// Their number.
        fn size(&self) -> u32;

        /// The number of this one, from 0.
        fn me(&self) -> u32;

        /// The words of all, by process.
        fn tell_all(&self, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Failure>;

        /// The points that the first process has read, dealt to all.
        fn deal(&self, whole: Option<Points>) -> Result<Points, Failure>;

        /// The points of all, validated.
        fn slice(&self, points: Vec<Point>) -> Result<Result<Slice, SliceError>, Failure>;

        /// The thickness of all points, if they are nearly in one plane.
        fn thickness(&self, slice: &Slice) -> Result<Option<Thickness>, Failure>;

        /// Builds the mesh; each process gets its part.
        fn build(&self, builder: &Builder<'_>, slice: &Slice) -> Result<BuiltPart, RunError>;

        /// Refines a domain; where the wishes say so each process keeps its part, if it may.
        fn refine(
            &self,
            refiner: &Refiner<'_>,
            ready: &Prepared,
            work: Work<'_>,
            wishes: Wishes<'_>,
        ) -> Result<TeamEnd<(Refined, Made)>, RefineError>;

        /// The hash of the mesh that the parts of all are.
        fn hash(&self, part: &Part) -> Result<Hashed, Failure>;

        /// Checks the mesh that the parts of all are.
        fn check(
            &self,
            part: &verify::Part<'_>,
            options: &verify::Options,
        ) -> Result<verify::Report, Failure>;

        /// Checks the mesh that the parts of all are against its domain.
        fn conforms(
            &self,
            part: &verify::DomainPart<'_>,
            plc: &verify::Plc,
            limits: &verify::Limits,
            options: &verify::Options,
        ) -> Result<verify::Conformity, Failure>;

        /// The tags of points by their numbers, if the points of all slices have tags.
        fn tags(
            &self,
            slice: &Slice,
            own: Option<&[i64]>,
            numbers: &[u32],
        ) -> Result<Option<Vec<i64>>, Failure>;

        /// The border of the part: all that it has in common with those of others.
        fn border(&self, piece: &Piece) -> Result<Border, Failure>;

        /// The tetrahedra of all parts, over this number of points, at the first process.
        fn gather(&self, part: &Part, points: usize) -> Result<Option<Gathered>, Failure>;

        /// The mesh of a domain at the first process: the pieces of all, and vertices beside them.
        fn join(
            &self,
            piece: Piece,
            beside: Part,
            vertices: u64,
        ) -> Result<Option<Joined>, Failure>;

        /// The points of all slices at the first process.
        fn gather_points(
            &self,
            slice: &Slice,
            tags: Option<&[i64]>,
        ) -> Result<Option<Points>, Failure>;
    }

    impl dyn Apart + '_ {
        /// Is this the one that reports?
        pub(crate) fn is_first(&self) -> bool {
            self.me() == 0
        }

        /// The values of all processes.
        pub(crate) fn all<T>(&self, own: &T) -> Result<Vec<T>, Failure>
        where
            T: Serialize + DeserializeOwned,
        {
            let lost = |error: ltbw::wire::WireError| Failure::Other(error.to_string());
            let own = bytes_of(own, WorkerId::new(self.me())).map_err(lost)?;
            let all = self.tell_all(own)?;
            let each = WorkerId::below(self.size()).zip(&all);
            each.map(|(from, bytes)| value_of(from, bytes).map_err(lost)).collect()
        }

        /// The work of this one, if all others have done theirs, too. The first failure is that of
        /// all; what is wrong with the input has no process's name.
        pub(crate) fn together<T>(&self, own: Result<T, Failure>) -> Result<T, Failure> {
            let word =
                |failure: &Failure| (failure.code(), failure.to_string(), failure.is_about_input());
            let all: Vec<Option<(u8, String, bool)>> = self.all(&own.as_ref().err().map(word))?;
            let first = (0..).zip(all).find_map(|(rank, word): (u32, _)| Some((rank, word?)));
            match first {
                None => own,
                Some((_, (code, why, true))) => Err(Failure::Agreed { code, why }),
                Some((rank, (code, why, false))) => {
                    Err(Failure::Agreed { code, why: of_rank(rank, &why) })
                }
            }
        }
    }
}
