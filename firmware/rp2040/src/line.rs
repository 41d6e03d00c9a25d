//! The serial line: a USB CDC device.

use embassy_executor::Spawner;
use embassy_rp::Peri;
use embassy_rp::bind_interrupts;
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_usb::class::cdc_acm::{CdcAcmClass, Receiver, Sender, State};
use embassy_usb::{Builder, Config, UsbDevice};
use sinew_firmware_common::line::{DOWN, PACKET, UP};
use static_cell::StaticCell;

bind_interrupts!(struct Irqs {
    USBCTRL_IRQ => InterruptHandler<USB>;
});

type Usb = Driver<'static, USB>;

/// Begins to speak.
pub fn start(usb: Peri<'static, USB>, serial: &'static str, spawner: Spawner) {
    static DESCRIPTORS: StaticCell<[[u8; 256]; 3]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static STATE: StaticCell<State> = StaticCell::new();
    let driver = Driver::new(usb, Irqs);
    interrupt::USBCTRL_IRQ.set_priority(Priority::P3);
    // pid.codes' number for tests: a maker of boards has its own.
    let mut config = Config::new(0x1209, 0x0001);
    config.manufacturer = Some("sinew");
    config.product = Some("sinew front-end");
    config.serial_number = Some(serial);
    config.max_power = 100;
    config.max_packet_size_0 = PACKET as u8;
    let [configuration, bos, ms] = DESCRIPTORS.init([[0; 256]; 3]);
    let mut builder = Builder::new(driver, config, configuration, bos, ms, CONTROL.init([0; 64]));
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET as u16);
    let (sender, receiver) = class.split();
    let device = builder.build();
    // Each of the three is started once, here.
    spawner.spawn(run(device).expect("one device"));
    spawner.spawn(up(sender).expect("one sender"));
    spawner.spawn(down(receiver).expect("one receiver"));
}

#[embassy_executor::task]
async fn run(mut device: UsbDevice<'static, Usb>) -> ! {
    device.run().await
}

#[embassy_executor::task]
async fn down(mut receiver: Receiver<'static, Usb>) -> ! {
    let mut packet = [0; PACKET];
    loop {
        receiver.wait_connection().await;
        while let Ok(count) = receiver.read_packet(&mut packet).await {
            DOWN.write_all(packet.get(..count).unwrap_or_default()).await;
        }
    }
}

#[embassy_executor::task]
async fn up(mut sender: Sender<'static, Usb>) -> ! {
    let mut packet = [0; PACKET];
    loop {
        sender.wait_connection().await;
        // What was for somebody who has gone is for nobody.
        UP.clear();
        loop {
            let count = UP.read(&mut packet).await;
            if sender.write_packet(packet.get(..count).unwrap_or_default()).await.is_err() {
                break;
            }
            // A full packet says that more follows: where nothing does, an empty one ends it.
            if count == PACKET && UP.is_empty() && sender.write_packet(&[]).await.is_err() {
                break;
            }
        }
    }
}
