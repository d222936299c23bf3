use super::*;

fn on_team<R: Send>(members: u32, member: impl Fn(&mut Team) -> R + Sync) -> Vec<R> {
    std::thread::scope(|scope| {
        let member = &member;
        let run = |post| scope.spawn(move || member(&mut Team::new(post)));
        let all: Vec<_> = threads(members).into_iter().map(run).collect();
        all.into_iter().map(|thread| thread.join().expect("a member does not panic")).collect()
    })
}

#[test]
fn collectives_bring_everything_where_it_belongs() {
    for members in [1, 2, 3, 5, 8, 13] {
        let own = |k: u32| vec![k as u8; 3 * k as usize];
        on_team(members, |team| {
            let me = team.me().number();
            let all = team.gather(own(me)).unwrap();
            let expected = (0..members).map(own).collect::<Vec<_>>();
            assert_eq!(all, team.is_first().then_some(expected));
            let told = team.tell(if me == 0 { vec![7, 8] } else { vec![] }).unwrap();
            assert_eq!(told, [7, 8], "member {me} of {members}");
            assert_eq!(
                team.gather_all(&(2 * me)).unwrap(),
                (0..members).map(|k| 2 * k).collect::<Vec<_>>()
            );
            assert!(!team.is_any(false).unwrap());
            assert!(team.is_any(me == members - 1).unwrap());
            let parts = (0..members).map(|to| vec![me as u8, to as u8]).collect();
            let theirs: Vec<_> = (0..members).map(|from| vec![from as u8, me as u8]).collect();
            assert_eq!(team.exchange(parts).unwrap(), theirs);
        });
    }
}

#[test]
fn what_is_large_goes_in_pieces() {
    let bytes: Vec<u8> = (0..2 * PIECE + 5).map(|k| (k % 251) as u8).collect();
    on_team(3, |team| {
        let all = team.gather(bytes.clone()).unwrap();
        assert!(all.is_none_or(|all| all.iter().all(|one| *one == bytes)));
        let told = team.tell(if team.is_first() { bytes.clone() } else { Vec::new() }).unwrap();
        assert!(told == bytes);
    });
}

#[test]
fn a_member_that_fails_is_heard_by_all() {
    let ends = on_team(3, |team| {
        if team.me() == WorkerId::new(2) {
            team.fail();
            return None;
        }
        Some(team.gather_all(&1_u32))
    });
    let failed = Some(Err(TeamError::Failed(WorkerId::new(2))));
    assert_eq!(ends, [failed.clone(), failed, None]);
}

#[test]
fn a_value_that_makes_no_sense_names_its_sender() {
    let ends = on_team(2, |team| {
        let own = if team.is_first() { vec![1] } else { vec![0xff; 9] };
        let all = team.gather(own).unwrap()?;
        let read = value_of::<Vec<u64>>(WorkerId::new(1), &all[1]);
        Some(read.unwrap_err())
    });
    let error = ends[0].clone().unwrap();
    assert_eq!((error.from, error.length), (WorkerId::new(1), 9));
    assert!(
        value_of::<u8>(WorkerId::new(1), &[3, 4]).unwrap_err().reason.contains("after its end")
    );
    // A length that is announced takes no memory before the elements are there.
    assert!(value_of::<Vec<[u64; 3]>>(WorkerId::new(1), &[0xff, 0xff, 0xff, 0xff, 0x7f]).is_err());
}

#[test]
fn a_team_of_one_needs_nobody() {
    let mut team = Team::alone();
    assert_eq!(team.gather_all(&5_u8).unwrap(), [5]);
    assert_eq!((team.size(), team.is_first(), team.error()), (1, true, None));
}
