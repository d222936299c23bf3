//! The way of a check in parts from one member of a team to another, in bytes.

/// The things that members of a team do all together, in one order. A member may be a process or a
/// thread: the checker needs no more of it than this.
pub trait Exchange {
    /// Why a team fails.
    type Error;

    /// The number of this member, from 0.
    fn me(&self) -> usize;

    /// Number of members, at least 1.
    fn members(&self) -> usize;

    /// Each member gets what the others have for it: parts by receiver in, by sender out, its own
    /// included.
    ///
    /// # Errors
    /// Those of the team.
    fn exchange(&mut self, parts: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, Self::Error>;

    /// Goes through all members in their order: each makes something of what the one before it has
    /// made, the first one of `first`. All get what the last one has made.
    ///
    /// # Errors
    /// Those of the team.
    fn in_turn(
        &mut self,
        first: Vec<u8>,
        own: &mut dyn FnMut(Vec<u8>) -> Vec<u8>,
    ) -> Result<Vec<u8>, Self::Error>;

    /// The error for bytes of member `from` that make no sense.
    fn nonsense(&self, from: usize, what: &'static str) -> Self::Error;
}

/// A value of one size, as it travels.
pub(crate) trait Record: Copy {
    /// Its bytes.
    const BYTES: usize;

    /// Adds them.
    fn put(&self, to: &mut Vec<u8>);

    /// The value of these bytes, of which there are [`Record::BYTES`].
    fn get(bytes: &[u8]) -> Self;

    /// Whether it is one that may be computed with.
    fn is_sound(&self) -> bool {
        true
    }
}

macro_rules! plain {
    ($($kind:ty),+) => { $(
        impl Record for $kind {
            const BYTES: usize = size_of::<$kind>();

            fn put(&self, to: &mut Vec<u8>) {
                to.extend(self.to_le_bytes());
            }

            fn get(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$kind>()];
                own.iter_mut().zip(bytes).for_each(|(own, byte)| *own = *byte);
                Self::from_le_bytes(own)
            }
        }
    )+ };
}

plain!(u32, u64, f64);

impl<R: Record, const N: usize> Record for [R; N] {
    const BYTES: usize = N * R::BYTES;

    fn put(&self, to: &mut Vec<u8>) {
        self.iter().for_each(|own| own.put(to));
    }

    fn get(bytes: &[u8]) -> Self {
        std::array::from_fn(|k| R::get(&bytes[k * R::BYTES..]))
    }
}

/// Values as bytes.
pub(crate) fn bytes_of<R: Record>(values: &[R]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * R::BYTES);
    values.iter().for_each(|value| value.put(&mut bytes));
    bytes
}

/// The values that bytes of member `from` are.
pub(crate) fn values_of<E: Exchange, R: Record>(
    team: &E,
    from: usize,
    bytes: &[u8],
) -> Result<Vec<R>, E::Error> {
    let values = bytes.chunks_exact(R::BYTES);
    if !values.remainder().is_empty() {
        return Err(team.nonsense(from, "the bytes end within a value"));
    }
    let all: Vec<R> = values.map(R::get).collect();
    match all.iter().all(R::is_sound) {
        true => Ok(all),
        false => Err(team.nonsense(from, "a value that cannot be computed with")),
    }
}

/// Sends each value to the member that `to` names; what has come, by sender.
pub(crate) fn deal<E: Exchange, R: Record>(
    team: &mut E,
    values: impl Iterator<Item = R>,
    to: impl Fn(&R) -> usize,
) -> Result<Vec<Vec<R>>, E::Error> {
    let mut parts = vec![Vec::new(); team.members()];
    for value in values {
        value.put(&mut parts[to(&value)]);
    }
    let all = team.exchange(parts)?;
    all.iter().enumerate().map(|(from, bytes)| values_of(team, from, bytes)).collect()
}

/// All members get the values of each, by member. For few.
pub(crate) fn tell_all<E: Exchange, R: Record>(
    team: &mut E,
    own: &[R],
) -> Result<Vec<Vec<R>>, E::Error> {
    let all = tell_all_bytes(team, &bytes_of(own))?;
    all.iter().enumerate().map(|(from, bytes)| values_of(team, from, bytes)).collect()
}

/// As [`tell_all`], of bytes.
pub(crate) fn tell_all_bytes<E: Exchange>(
    team: &mut E,
    own: &[u8],
) -> Result<Vec<Vec<u8>>, E::Error> {
    let parts = vec![own.to_vec(); team.members()];
    team.exchange(parts)
}

/// The sums over all members.
pub(crate) fn sums<E: Exchange, const N: usize>(
    team: &mut E,
    own: [u64; N],
) -> Result<[u64; N], E::Error> {
    let all = tell_all(team, &[own])?;
    Ok(all
        .iter()
        .flatten()
        .fold([0_u64; N], |sum, own| std::array::from_fn(|k| sum[k].saturating_add(own[k]))))
}

/// The sum of the numbers of all members before this one, and of all.
pub(crate) fn before<E: Exchange>(team: &mut E, own: u64) -> Result<[u64; 2], E::Error> {
    let all: Vec<u64> = tell_all(team, &[own])?.into_iter().flatten().collect();
    let sum = |all: &[u64]| all.iter().fold(0_u64, |sum, own| sum.saturating_add(*own));
    Ok([sum(&all[..team.me().min(all.len())]), sum(&all)])
}

/// A member for a few numbers, whatever else they mean: about as many for each.
pub(crate) fn member_of(numbers: &[u32], members: usize) -> usize {
    let mixed = numbers.iter().fold(0_u64, |mixed, &n| {
        let mixed = (mixed ^ u64::from(n)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 29)
    });
    (((mixed >> 32) * members as u64) >> 32) as usize
}

/// Values of each member that say where stretches are cut.
const SAMPLES: usize = 64;

/// The first values of the stretches of all members but the first, if what all have is sorted: the
/// same at all members. `own` is sorted.
pub(crate) fn cuts<E, R>(team: &mut E, own: &[R]) -> Result<Vec<R>, E::Error>
where
    E: Exchange,
    R: Record + Ord,
{
    let count = own.len().min(SAMPLES);
    let samples: Vec<R> = (0..count).map(|k| own[(2 * k + 1) * own.len() / (2 * count)]).collect();
    let lengths = tell_all(team, &[own.len() as u64])?;
    let samples = tell_all(team, &samples)?;
    // Each stands for as many values as any other of its member.
    let weigh = |(length, samples): (Vec<u64>, Vec<R>)| {
        let length = length.first().copied().unwrap_or_default();
        let weight = length as f64 / samples.len().max(1) as f64;
        samples.into_iter().map(move |sample| (sample, weight))
    };
    let mut samples: Vec<(R, f64)> = lengths.into_iter().zip(samples).flat_map(weigh).collect();
    samples.sort_by_key(|&(sample, _)| sample);
    let whole: f64 = samples.iter().map(|&(_, weight)| weight).sum();
    let members = team.members();
    let (mut cuts, mut before) = (Vec::with_capacity(members), 0.0);
    for &(sample, weight) in &samples {
        let next = |cuts: &Vec<R>| whole * (cuts.len() + 1) as f64 / members as f64;
        while cuts.len() + 1 < members && before >= next(&cuts) {
            cuts.push(sample);
        }
        before += weight;
    }
    if let Some(&(last, _)) = samples.last() {
        cuts.resize(members - 1, last);
    }
    Ok(cuts)
}

/// The member whose stretch a value belongs to.
pub(crate) fn stretch<R: Ord>(cuts: &[R], value: &R) -> usize {
    cuts.partition_point(|cut| cut <= value)
}
