// Pointer, touch, wheel and keys, as commands to a player.

import { moved } from "./math.js";

/** Radians of orbit per pixel that the pointer is dragged. */
const ORBIT_PER_PIXEL = 0.008;
/** Radians of orbit by an arrow key. */
const ORBIT_PER_KEY = 0.06;
/** Zoom by a key. */
const ZOOM_PER_KEY = 0.9;
/** Distance flown a second, in pivot distances. */
const FLY_PER_SECOND = 0.6;
/** Keys that fly, by their place on the keyboard: axis and direction. */
const FLIGHT = { KeyD: [0, 1], KeyA: [0, -1], KeyQ: [1, 1], KeyE: [1, -1], KeyW: [2, 1], KeyS: [2, -1] };

/** Lets people move the view of a player. */
export class Controls {
  constructor(player, canvas) {
    this.player = player;
    this.canvas = canvas;
    this.pointers = new Map();
    this.held = new Set();
    this.isFast = false;
    const listen = (target, names, handler, options) => names.split(" ").forEach((name) => target.addEventListener(name, handler, options));
    listen(canvas, "pointerdown", (event) => this.press(event));
    listen(canvas, "pointermove", (event) => this.drag(event));
    listen(canvas, "pointerup pointercancel", (event) => this.pointers.delete(event.pointerId));
    listen(canvas, "contextmenu", (event) => event.preventDefault());
    listen(canvas, "wheel", (event) => this.wheel(event), { passive: false });
    listen(canvas, "dblclick", () => player.goHome());
    listen(window, "keydown", (event) => this.key(event));
    listen(window, "keyup", (event) => this.held.delete(event.code));
    listen(window, "blur", () => this.held.clear());
  }

  press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus({ preventScroll: true });
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
    const height = this.canvas.clientHeight;
    if (this.pointers.size === 1) {
      Object.assign(before, { x: event.clientX, y: event.clientY });
      const pans = event.shiftKey || event.buttons & 6;
      this.player.move((view) => pans ? view.pan(dx / height, dy / height) : view.orbit(dx * ORBIT_PER_PIXEL, dy * ORBIT_PER_PIXEL));
      return;
    }
    // Two fingers shift by their middle and zoom by their distance.
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
    const distance = (a) => Math.max(Math.hypot(a.x - other.x, a.y - other.y), 1);
    const factor = distance(before) / distance({ x: event.clientX, y: event.clientY });
    Object.assign(before, { x: event.clientX, y: event.clientY });
    this.player.move((view) => {
      view.pan(dx / 2 / height, dy / 2 / height);
      view.dolly(factor);
    });
  }

  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 20 : event.deltaMode === WheelEvent.DOM_DELTA_PAGE ? 400 : 1;
    const factor = Math.exp(event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.0015));
    const point = this.player.pointAt(event.clientX, event.clientY);
    this.player.move((view) => point ? view.dollyTo(factor, point) : view.dolly(factor));
  }

  key(event) {
    const { target, key, code } = event;
    const typing = target.closest?.("input, select, textarea, dialog");
    if (event.ctrlKey || event.metaKey || event.altKey || typing) return;
    // Space presses the button that has the focus.
    if (key === " " && target.closest?.("button, summary, a")) return;
    if (code in FLIGHT) {
      this.isFast = event.shiftKey;
      this.held.add(code);
      this.player.wake();
      return;
    }
    if (this.command(key, event.shiftKey)) event.preventDefault();
  }

  /** Carries out a key; false if it means nothing. */
  command(key, hasShift) {
    const { player } = this;
    const orbits = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key];
    if (orbits && (hasShift || key === "ArrowUp" || key === "ArrowDown")) {
      player.move((view) => view.orbit(orbits[0] * ORBIT_PER_KEY, orbits[1] * ORBIT_PER_KEY));
      return true;
    }
    const commands = {
      " ": () => player.togglePlay(),
      ArrowLeft: () => player.step(-1),
      ArrowRight: () => player.step(1),
      Home: () => player.goHome(),
      "+": () => player.move((view) => view.dolly(ZOOM_PER_KEY)),
      "=": () => player.move((view) => view.dolly(ZOOM_PER_KEY)),
      "-": () => player.move((view) => view.dolly(1 / ZOOM_PER_KEY)),
      l: () => player.toggleLoop(),
      p: () => player.toggleFollow(),
      f: () => player.toggleFullScreen(),
      "?": () => player.showHelp(),
    };
    const camera = Number(key) - 1;
    const command = commands[key.length === 1 ? key.toLowerCase() : key]
      ?? (camera >= 0 && camera < player.scene.cameras.length ? () => player.goToCamera(camera) : null);
    command?.();
    return Boolean(command);
  }

  /** Whether something moves the view all the time. */
  isFlying() {
    return this.held.size > 0;
  }

  /** Whether the view is being dragged. */
  isDragging() {
    return this.pointers.size > 0;
  }

  /** Flies on for some seconds. */
  fly(seconds) {
    const steps = [0, 0, 0];
    for (const code of this.held) steps[FLIGHT[code][0]] += FLIGHT[code][1];
    const pace = FLY_PER_SECOND * (this.isFast ? 4 : 1) * Math.min(seconds, 0.1);
    this.player.move((view) => view.fly(steps.map((step) => step * pace)));
  }
}

/** The point at a pixel of a picture, from its inverse depth; null at infinity. */
export function pointOf(pose, lens, x, y, inverseDepth) {
  if (!(inverseDepth > 0)) return null;
  const z = 1 / inverseDepth;
  return moved(pose, [(x - lens[4]) / lens[2] * z, (y - lens[5]) / lens[3] * z, z]);
}
