//! What a page on the network has to open before it is shown anything: a PIN, for which it gets the token of its session.
//!
//! A PIN is eight digits, which somebody who has the terminal before him types. It is short enough to be guessed by a program that may
//! try on, so wrong ones are few, whoever sends them: ten at once, then one a minute ([`Limits::pins`](sinew_server::Limits::pins)),
//! and after each ten there is another PIN. In a day that is 1450 tries of 10⁸: one scope in 69 000 is opened by guessing.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use sinew_server::{Allowance, Flow};
use subtle::ConstantTimeEq;

use crate::Error;
use crate::access::Token;

/// Digits of a PIN.
const DIGITS: u32 = 8;
/// After so many wrong ones there is another PIN.
const RENEWED_AFTER: u32 = 10;

/// The lock, the same for all pages of the network.
pub struct Lock {
    /// That of every session: what a page shows that had the PIN once, when it connects anew.
    session: Token,
    pin: Mutex<Tried>,
    /// Whether a page that has opened it may command and record.
    commands: bool,
}

struct Tried {
    pin: Pin,
    wrong: u32,
    allowed: Allowance,
}

/// What became of a PIN.
#[derive(Debug, PartialEq, Eq)]
pub enum Try {
    Right,
    Wrong,
    /// So was the one before, too often: there is another PIN now.
    Renewed(Pin),
    /// It was not looked at.
    TooSoon,
}

impl Lock {
    /// A new one, for so many wrong PINs.
    ///
    /// # Errors
    /// [`Error::Random`] when the system gives no random bits.
    pub fn new(pins: Flow, commands: bool) -> Result<Lock, Error> {
        let tried = Tried { pin: Pin::new()?, wrong: 0, allowed: Allowance::new(pins, Instant::now()) };
        Ok(Lock { session: Token::new()?, pin: Mutex::new(tried), commands })
    }

    /// The PIN of now.
    pub fn pin(&self) -> Pin {
        self.pin.lock().unwrap_or_else(PoisonError::into_inner).pin.clone()
    }

    /// The token that a right PIN is answered with.
    pub fn session(&self) -> &Token {
        &self.session
    }

    /// Whether a page that has opened it may command and record.
    pub fn commands(&self) -> bool {
        self.commands
    }

    /// How long it takes until a PIN is looked at.
    pub fn wait(&self, now: Instant) -> Duration {
        self.pin.lock().unwrap_or_else(PoisonError::into_inner).allowed.wait(1.0, now)
    }

    /// Tries a PIN, as it was typed.
    pub fn open(&self, offered: &str, now: Instant) -> Try {
        let mut tried = self.pin.lock().unwrap_or_else(PoisonError::into_inner);
        // not even a right one is looked at in the pause: else a pause would keep nobody from guessing
        if !tried.allowed.take(1.0, now) {
            return Try::TooSoon;
        }
        if tried.pin.matches(offered) {
            tried.allowed.put_back(1.0);
            return Try::Right;
        }
        tried.wrong += 1;
        if tried.wrong.is_multiple_of(RENEWED_AFTER)
            // a system that gave random bits before and gives none now: the old one stays, and its bounds
            && let Ok(pin) = Pin::new()
        {
            tried.pin = pin.clone();
            return Try::Renewed(pin);
        }
        Try::Wrong
    }
}

/// Eight random digits.
#[derive(Clone, PartialEq, Eq)]
pub struct Pin(String);

impl Pin {
    fn new() -> Result<Pin, Error> {
        let most = 10_u32.pow(DIGITS);
        loop {
            let mut bits = [0; 4];
            getrandom::fill(&mut bits).map_err(|e| Error::Random { reason: e.to_string() })?;
            let number = u32::from_le_bytes(bits);
            // those beyond the last whole multiple would make the low ones likelier
            if number < u32::MAX / most * most {
                return Ok(Pin(format!("{:08}", number % most)));
            }
        }
    }

    /// As it is read and typed, in two halves: `4821 7735`.
    pub fn spaced(&self) -> String {
        let (first, second) = self.0.split_at(DIGITS as usize / 2);
        format!("{first} {second}")
    }

    /// Whether this was typed, with blanks or without; compared in constant time.
    fn matches(&self, offered: &str) -> bool {
        let typed: String = offered.chars().filter(|c| !c.is_whitespace()).take(DIGITS as usize + 1).collect();
        self.0.as_bytes().ct_eq(typed.as_bytes()).into()
    }
}

/// Not for logs.
impl std::fmt::Debug for Pin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Pin(…)")
    }
}

#[cfg(test)]
mod tests {
    use sinew_server::Limits;

    use super::*;

    fn lock() -> Lock {
        Lock::new(Limits::default().pins, false).unwrap()
    }

    /// One that is not its PIN.
    fn wrong(lock: &Lock) -> String {
        let first = lock.pin().0.bytes().next().unwrap();
        format!("{}{}", if first == b'0' { 1 } else { 0 }, &lock.pin().0[1..])
    }

    #[test]
    fn a_pin_is_opened_by_itself_alone() {
        let (lock, now) = (lock(), Instant::now());
        let pin = lock.pin();
        let spaced = pin.spaced();
        assert_eq!((spaced.len(), spaced.matches(|c: char| c.is_ascii_digit()).count(), &spaced[4..5]), (9, 8, " "));
        for typed in [pin.0.clone(), spaced, format!(" {} {}\n", &pin.0[..3], &pin.0[3..])] {
            assert_eq!(lock.open(&typed, now), Try::Right, "{typed:?}");
        }
        for typed in
            ["", &pin.0[..7], &format!("{}0", pin.0), &format!("-{}", pin.0), &"0".repeat(1 << 20), &wrong(&lock)]
        {
            assert_eq!(lock.open(typed, now), Try::Wrong, "{typed:.20}");
        }
    }

    #[test]
    fn wrong_pins_are_few_and_the_tenth_makes_another() {
        let (lock, start) = (lock(), Instant::now());
        let after = |s| start + Duration::from_secs(s);
        let first = lock.pin();
        for _ in 1..10 {
            assert_eq!(lock.open(&wrong(&lock), start), Try::Wrong);
        }
        let renewed = lock.open(&wrong(&lock), start);
        assert_eq!(renewed, Try::Renewed(lock.pin()));
        assert_ne!(lock.pin(), first);
        // nothing is looked at now, and to ask costs nothing
        for _ in 0..100 {
            assert_eq!(lock.open(&lock.pin().0, after(20)), Try::TooSoon);
            assert_eq!(lock.wait(after(20)).as_secs_f64().round(), 40.0);
        }
        assert_eq!(lock.open(&lock.pin().0, after(61)), Try::Right);
        assert_eq!(lock.open(&first.0, after(61)), Try::Wrong, "the one before");
        assert_eq!(lock.open(&lock.pin().0, after(62)), Try::TooSoon);

        // whoever tries as often as he is let, a whole day long
        let (mut tries, mut pins) = (0, 0);
        for s in (0..86_400).map(|s| s + 61) {
            match lock.open(&wrong(&lock), after(s)) {
                Try::Wrong => tries += 1,
                Try::Renewed(_) => (tries, pins) = (tries + 1, pins + 1),
                Try::TooSoon => {}
                Try::Right => panic!("a wrong one"),
            }
        }
        assert!((1439..=1441).contains(&tries) && (143..=145).contains(&pins), "{tries}, {pins}");
    }

    #[test]
    fn every_pin_is_as_likely_as_any_other() {
        // each digit at each place a tenth of the time: six standard deviations of 20 000 throws
        let mut counts = [[0_u32; 10]; DIGITS as usize];
        for _ in 0..20_000 {
            for (place, digit) in Pin::new().unwrap().0.bytes().enumerate() {
                counts[place][usize::from(digit - b'0')] += 1;
            }
        }
        assert!(counts.iter().flatten().all(|count| count.abs_diff(2000) < 255), "{counts:?}");
    }
}
