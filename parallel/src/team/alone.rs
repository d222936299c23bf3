//! Work of the first member that all others wait for: whoever of them is stopped stops it.

use super::{Kind, Team, TeamError};
use crate::protocol::WorkerId;
use ltbw_core::CancelToken;
use std::collections::VecDeque;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::{Builder, scope, sleep};
use std::time::Duration;

/// The time from one look for stops, or for the end, to the next.
const LOOK: Duration = Duration::from_millis(1);

/// The stack of such work: as the main thread of a program has.
const STACK: usize = 8 << 20;

impl Team {
    /// Does work at the first member, while all others [`Team::wait_for_first`]. `cancel` is set as
    /// soon as theirs is, which the work has to look at.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub(crate) fn work_alone<T: Send>(
        &mut self,
        cancel: &CancelToken,
        work: impl FnOnce() -> T + Send,
    ) -> Result<T, TeamError> {
        if self.size() == 1 {
            return Ok(work());
        }
        // Letters are this thread's.
        let made = scope(|scope| {
            let (over, is_over) = channel::<()>();
            let worker = Builder::new().stack_size(STACK).spawn_scoped(scope, move || {
                // The other end hears of its drop, which follows a panic, too.
                let _over = over;
                work()
            });
            while is_over.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                self.sort();
                if self.mails.iter().any(|mail| mail.says_stop()) {
                    cancel.cancel();
                }
            }
            worker.map(|own| own.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        });
        // A word that comes later is said again with the next letters.
        self.mails.retain(|mail| !mail.says_stop());
        self.tell(Vec::new())?;
        // A machine without a thread for it has failed; the others have been told to go on.
        made.map_err(|_| TeamError::Failed(self.me()))
    }

    /// Waits until the first member has done its work ([`Team::work_alone`]), and tells it once if
    /// this one is stopped.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub(crate) fn wait_for_first(&mut self, cancel: &CancelToken) -> Result<(), TeamError> {
        let (first, mut has_told) = (WorkerId::default(), false);
        // Ends as `receive` does.
        while self.letters.iter().all(VecDeque::is_empty) && self.post.failed().is_none() {
            if cancel.is_cancelled() && !has_told {
                has_told = true;
                self.post.send(first, Kind::Mail, Vec::new());
                self.post.flush();
            }
            // MPI lets go of letters that have arrived when it is asked.
            self.post.flush();
            sleep(LOOK);
            self.sort();
        }
        self.tell(Vec::new()).map(drop)
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;
    use crate::team::threads;

    #[test]
    fn any_member_stops_the_first_ones_work() {
        for stopped in 0..5 {
            let word = scope(|scope| {
                let run = |(me, post)| {
                    let (token, mut team) = (CancelToken::new(), Team::new(post));
                    if me == stopped {
                        token.cancel();
                    }
                    let heard = match team.is_first() {
                        true => team.work_alone(&token, || {
                            while !token.is_cancelled() {
                                sleep(LOOK);
                            }
                        }),
                        false => team.wait_for_first(&token),
                    };
                    heard.expect("nobody has failed");
                    assert!(token.is_cancelled() || (me != 0 && me != stopped));
                    // The next collective is in order.
                    team.gather_all(&me).expect("all numbers")
                };
                let all: Vec<_> =
                    (0..5).zip(threads(5)).map(|own| scope.spawn(move || run(own))).collect();
                all.into_iter().map(|own| own.join().expect("no panic")).collect::<Vec<_>>()
            });
            assert_eq!(word, vec![vec![0, 1, 2, 3, 4]; 5], "{stopped}");
        }
    }

    #[test]
    fn work_of_one_takes_no_thread() {
        let here = std::thread::current().id();
        let there = Team::new(crate::team::Alone)
            .work_alone(&CancelToken::new(), || std::thread::current().id());
        assert_eq!(there, Ok(here));
    }
}
