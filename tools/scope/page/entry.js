// The PIN: on the network (a page that came by HTTPS) the scope shows nothing before somebody has typed what its terminal shows.
//
// A right PIN is answered with a token, which comes back by itself when the connection was lost. It is kept for as long as the tab,
// in the storage of this origin: a cookie would be sent to every other port of the host as well.
"use strict";

class Entry {
  static KEPT = "sinew session";

  // Asks in `form`; `connect` connects anew, which says `knock` first.
  constructor(form, connect) {
    this.form = form;
    this.needed = location.protocol === "https:";
    this.asks = false;
    [this.input, this.words, this.button] = ["input", "[role=alert]", "button"].map((what) => form.querySelector(what));
    form.onsubmit = (event) => {
      event.preventDefault();
      if (this.button.disabled || !this.input.value.trim()) return;
      this.say("");
      this.wait(0, true);
      connect();
    };
  }

  get token() { return sessionStorage.getItem(Entry.KEPT); }

  // What is said first on a connection.
  knock() { return this.asks ? { do: "pin", pin: this.input.value } : { do: "token", token: this.token }; }

  // What came of it. Whoever is let in is asked no more; else the scope closes the connection.
  answered({ ok, token, message, wait_s }) {
    if (ok) {
      sessionStorage.setItem(Entry.KEPT, token);
      this.show(false);
    } else {
      sessionStorage.removeItem(Entry.KEPT);
      this.ask(message, wait_s);
    }
  }

  // The connection has ended before there was an answer, for this reason if the scope gave one.
  unanswered(reason) { if (this.button.disabled && !this.timer) this.ask(reason || "The scope cannot be reached."); }

  // Asks for the PIN; `message` says what was wrong with the last one, and `wait_s` how long no other is looked at, s.
  ask(message = "", wait_s = 0) {
    this.show(true);
    this.say(message + (wait_s > 0 ? ` Wait ${Entry.lasting(wait_s)}.` : ""));
    this.wait(wait_s);
    this.input.focus();
    this.input.select();
  }

  show(asks) {
    this.asks = asks;
    this.form.hidden = !asks;
    document.body.classList.toggle("locked", asks);
  }

  say(words) {
    this.words.textContent = words;
    this.input.setAttribute("aria-invalid", String(words !== ""));
  }

  // Until then the button cannot be pressed, and says how long.
  wait(seconds, asking = false) {
    const until = performance.now() + 1000 * seconds;
    clearInterval(this.timer);
    const count = () => {
      const left = (until - performance.now()) / 1000;
      this.button.disabled = left > 0 || asking;
      this.button.textContent = left > 0 ? `Watch in ${Entry.lasting(left)}` : asking ? "…" : "Watch";
      if (left <= 0) { clearInterval(this.timer); this.timer = null; }
    };
    this.timer = seconds > 0 ? setInterval(count, 250) : null;
    count();
  }

  static lasting(seconds) { return `${Math.ceil(seconds)} s`; }
}
