//! A PWM chip that behaves like `drivers/pwm/core.c` and `drivers/pwm/sysfs.c`.

use std::time::Instant;

use fuser::Errno;

/// One output.
#[derive(Debug, Clone, Default)]
pub struct Output {
    /// Whether it was asked for through `export`.
    pub exported: bool,
    /// Whether a driver of the kernel has it.
    pub taken: bool,
    /// Period, ns.
    pub period_ns: u64,
    /// On-time, ns.
    pub on_ns: u64,
    /// Whether it runs.
    pub enabled: bool,
    /// Whether the on-phase is low.
    pub inversed: bool,
    /// When what is put out last changed.
    pub changed: Option<Instant>,
    /// How often it was written to.
    pub writes: u64,
}

impl Output {
    /// Duty that is put out, 0 ..= 1.
    pub fn duty(&self) -> f64 {
        if self.enabled && self.period_ns > 0 { self.on_ns as f64 / self.period_ns as f64 } else { 0.0 }
    }

    /// What an attribute says.
    pub fn show(&self, attribute: &str) -> Option<String> {
        Some(match attribute {
            "period" => format!("{}\n", self.period_ns),
            "duty_cycle" => format!("{}\n", self.on_ns),
            "enable" => format!("{}\n", u8::from(self.enabled)),
            "polarity" => format!("{}\n", if self.inversed { "inversed" } else { "normal" }),
            "capture" | "uevent" => String::new(),
            _ => return None,
        })
    }

    /// What writing to an attribute does: a state is applied as a whole, and refused as a whole.
    pub fn store(&mut self, attribute: &str, text: &str) -> Result<(), Errno> {
        let number = || text.parse::<u64>().map_err(|_| Errno::EINVAL);
        let mut next = self.clone();
        next.writes += 1;
        match attribute {
            "period" => next.period_ns = number()?,
            "duty_cycle" => next.on_ns = number()?,
            "enable" => {
                next.enabled = match number()? {
                    0 => false,
                    1 => true,
                    _ => return Err(Errno::EINVAL),
                }
            }
            "polarity" => {
                next.inversed = match text {
                    "normal" => false,
                    "inversed" => true,
                    _ => return Err(Errno::EINVAL),
                };
                // As most chips have it; the core itself does not mind.
                if next.inversed != self.inversed && self.enabled {
                    return Err(Errno::EBUSY);
                }
            }
            _ => return Err(Errno::EACCES),
        }
        if next.period_ns == 0 || next.on_ns > next.period_ns {
            return Err(Errno::EINVAL);
        }
        if next.duty() != self.duty() {
            next.changed = Some(Instant::now());
        }
        *self = next;
        Ok(())
    }
}

/// A chip: outputs, of which the exported ones have a folder.
#[derive(Debug, Clone)]
pub struct Chip {
    /// Name of its device.
    pub device: String,
    /// Its outputs.
    pub outputs: Vec<Output>,
}

impl Chip {
    /// Writing to `export` or `unexport`.
    pub fn store(&mut self, attribute: &str, text: &str) -> Result<(), Errno> {
        let number: usize = text.parse().map_err(|_| Errno::EINVAL)?;
        let output = self.outputs.get_mut(number).ok_or(Errno::ENODEV)?;
        match attribute {
            "export" if output.exported || output.taken => Err(Errno::EBUSY),
            "export" => {
                output.exported = true;
                Ok(())
            }
            "unexport" if !output.exported => Err(Errno::ENODEV),
            // The output goes on with what it does: only some chips switch it off here.
            "unexport" => {
                output.exported = false;
                Ok(())
            }
            _ => Err(Errno::EACCES),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_without_period_or_with_more_duty_than_period_is_refused() {
        let mut output = Output::default();
        let refused = |result: Result<(), Errno>| result.unwrap_err().code();
        let einval = Errno::EINVAL.code();
        assert_eq!(refused(output.store("enable", "1")), einval, "no period yet");
        assert_eq!(refused(output.store("duty_cycle", "0")), einval, "no period yet");
        output.store("period", "1000").unwrap();
        output.store("duty_cycle", "600").unwrap();
        assert_eq!(refused(output.store("duty_cycle", "1001")), einval);
        assert_eq!(refused(output.store("period", "500")), einval);
        assert_eq!(output.duty(), 0.0, "not enabled");
        output.store("enable", "1").unwrap();
        assert_eq!(output.duty(), 0.6);
        assert_eq!(refused(output.store("polarity", "inversed")), Errno::EBUSY.code());
        assert_eq!(refused(output.store("enable", "2")), einval);
        assert_eq!(output.show("duty_cycle").unwrap(), "600\n");
    }

    #[test]
    fn an_output_is_exported_once_and_goes_on_when_it_is_no_longer() {
        let mut chip = Chip { device: "1-0040".into(), outputs: vec![Output::default(); 2] };
        chip.store("export", "1").unwrap();
        assert_eq!(chip.store("export", "1").unwrap_err().code(), Errno::EBUSY.code());
        assert_eq!(chip.store("export", "2").unwrap_err().code(), Errno::ENODEV.code());
        chip.outputs[1].store("period", "1000").unwrap();
        chip.outputs[1].store("duty_cycle", "1000").unwrap();
        chip.outputs[1].store("enable", "1").unwrap();
        chip.store("unexport", "1").unwrap();
        assert_eq!(chip.store("unexport", "1").unwrap_err().code(), Errno::ENODEV.code());
        assert_eq!(chip.outputs[1].duty(), 1.0, "the kernel heats on");
    }
}
