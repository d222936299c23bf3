//! The real mailbox under loom: every interleaving of 2 or 3 threads.
//!
//! loom can miss outcomes of plain loads and stores (tokio-rs/loom#392); the mailbox has none, all
//! its state is behind locks. Every model says which outcomes it must see and how many executions
//! it must run, and has a twin that must fail.
#![cfg(loom)]

use loom::sync::Arc;
use loom::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use loom::thread;
use ltbw::mailbox::{Endpoint, connect_as};
use ltbw::protocol::{Correct, Rules, WorkerId};
use ltbw_models::report::{caught, row};
use ltbw_models::threads::Kept;
use ltbw_models::variants::{Defect, KnownBad};
use std::collections::BTreeSet;
use std::sync::Mutex;

/// The worker that receives.
const TO: WorkerId = WorkerId::new(0);

/// Runs `model` in every interleaving; returns the outcomes and the number of executions.
fn outcomes<T: Ord + Clone + Send + 'static>(
    model: impl Fn() -> T + Send + Sync + 'static,
) -> (BTreeSet<T>, usize) {
    let seen = std::sync::Arc::new(Mutex::new((BTreeSet::new(), 0)));
    let record = seen.clone();
    loom::model(move || {
        let outcome = model();
        let mut record = record.lock().expect("no panic while locked");
        record.0.insert(outcome);
        record.1 += 1;
    });
    let seen = seen.lock().expect("no panic while locked");
    (seen.0.clone(), seen.1)
}

/// Receives `count` messages, sleeping in between; returns them with their senders' numbers, in
/// order of arrival.
fn receive<C: Rules>(end: &mut Endpoint<u32, C>, count: usize) -> Vec<(u32, u32)> {
    let mut taken = Vec::new();
    while taken.len() < count {
        end.wait();
        end.try_take(&mut taken);
    }
    taken.into_iter().map(|received| (received.from.number(), received.message)).collect()
}

/// Two senders, one of them in two batches, and a receiver that sleeps.
fn two_senders<C: Rules>() -> Vec<(u32, u32)> {
    let mut ends = connect_as::<u32, C>(3).into_iter().map(Kept::new);
    let (mut me, mut first, mut second) =
        (ends.next().expect("3"), ends.next().expect("3"), ends.next().expect("3"));
    let one = thread::spawn(move || {
        first.send(TO, 10);
        first.flush();
        first.send(TO, 11);
        first.flush();
        drop(Kept::into_inner(first));
    });
    let two = thread::spawn(move || {
        second.send(TO, 20);
        second.send(TO, 21);
        second.flush();
        drop(Kept::into_inner(second));
    });
    let taken = receive(&mut me, 4);
    one.join().expect("senders do not panic");
    two.join().expect("senders do not panic");
    drop(Kept::into_inner(me));
    taken
}

#[test]
fn messages_arrive_in_order_and_wake() {
    let (orders, executions) = outcomes(two_senders::<Correct>);
    for order in &orders {
        let of = |from| order.iter().filter(move |m| m.0 == from).map(|m| m.1).collect::<Vec<_>>();
        assert_eq!((of(1), of(2)), (vec![10, 11], vec![20, 21]), "{order:?}");
    }
    // A batch stays together, so that the second sender's comes first, between or last.
    assert_eq!(orders.len(), 3, "{orders:?}");
    assert!(executions >= 100, "{executions}");
    let explored = format!("{executions} executions, {} orders", orders.len());
    row("loom: mailbox", "3 threads, 4 messages", &explored, "in order, all woken");
}

/// Known bad, a switch in the mailbox itself: the inbox is tested in one critical section, sleep
/// begins in another.
#[test]
fn a_lost_wake_up_is_caught() {
    let said = caught(|| drop(Defect::LostWakeUp.planted(|| outcomes(two_senders::<KnownBad>))));
    assert!(said.contains("deadlock"), "{said}");
    row("known bad: lost wake-up", "loom, 3 threads", "until it fails", "caught: deadlock");
}

#[test]
fn a_failure_is_heard() {
    let (outcomes, executions) = outcomes(|| {
        let mut ends = connect_as::<u32, Correct>(2).into_iter();
        let (mut me, mut other) = (ends.next().expect("2"), ends.next().expect("2"));
        let thread = thread::spawn(move || {
            other.send(TO, 1);
            other.flush();
            other.fail();
        });
        me.wait();
        let mut taken = Vec::new();
        me.try_take(&mut taken);
        let early = me.failed().is_some();
        while me.failed().is_none() {
            me.wait();
            me.try_take(&mut taken);
        }
        thread.join().expect("it does not panic");
        assert_eq!((me.failed(), taken.len()), (Some(WorkerId::new(1)), 1));
        early
    });
    assert_eq!(outcomes, BTreeSet::from([false, true]), "with the message, and after it");
    assert!(executions >= 4, "{executions}");
    let explored = format!("{executions} executions, both orders");
    row("loom: a failed worker", "2 threads", &explored, "heard");
}

/// Publication without a lock, as the mailbox does *not* do it: a flag says that a payload is
/// there. The payload is loaded, not swapped: a read-modify-write would always see the last value.
fn publish(order: (Ordering, Ordering)) -> Option<u32> {
    let slot = Arc::new((AtomicU32::new(0), AtomicBool::new(false)));
    let theirs = slot.clone();
    let sender = thread::spawn(move || {
        theirs.0.store(7, Ordering::Relaxed);
        theirs.1.swap(true, order.0);
    });
    let taken = slot.1.swap(false, order.1).then(|| slot.0.load(Ordering::Relaxed));
    sender.join().expect("the sender does not panic");
    taken
}

#[test]
fn released_publication_is_seen_whole() {
    let (seen, executions) = outcomes(|| publish((Ordering::Release, Ordering::Acquire)));
    assert_eq!(seen, BTreeSet::from([None, Some(7)]));
    assert!(executions >= 2, "{executions}");
}

/// Known bad: the flag is seen, the payload is not. In the mailbox there is no ordering to get
/// wrong, the lock publishes; this twin shows that loom would see it.
#[test]
fn relaxed_publication_is_caught() {
    let (seen, executions) = outcomes(|| publish((Ordering::Relaxed, Ordering::Relaxed)));
    assert!(seen.contains(&Some(0)), "loom does not see it: {seen:?}");
    let explored = format!("{executions} executions");
    row("known bad: relaxed publication", "loom, 2 threads", &explored, "caught: stale payload");
}
