// The player: loads the samples while it shows them, lets time pass, and keeps the page and the address true to what is shown.

import { between } from "./math.js";
import { servesAsDecoder } from "./decoders.js";
import { CannotDraw } from "./canvas.js";
import { View } from "./view.js";
import { fragmentOf, readFragment, roundView } from "./address.js";
import { Controls, pointOf } from "./controls.js";
import { load } from "./load.js";

/** The finest and the coarsest picture while it moves, in pixels per recorded pixel along each side; finer where the device is fast. */
const [FINEST, COARSEST] = [2, 0.45];
/** Pictures with fewer pixels per recorded pixel are drawn from a quarter, and from a sixteenth, of the samples. */
const FEWER_SAMPLES = [0.8, 0.55];
/** Milliseconds between pictures above which they get coarser, and below which finer. */
const [SLOW, FAST] = [100, 24];
/** A view rests after this many milliseconds. */
const REST = 200;
/** Pictures of a part of the first frame are this many milliseconds apart. */
const PART_INTERVAL = 1000;
/** A view at rest is drawn in steps, as many at a time as take between so many milliseconds: keys are heard in between. */
const [SHORT_STEPS, LONG_STEPS] = [20, 60];

const element = (id) => document.getElementById(id);
const root = globalThis.document?.documentElement;

class Player {
  constructor(scene) {
    this.scene = scene;
    this.canvas = element("picture");
    this.renderer = null;
    this.view = new View(scene);
    this.controls = new Controls(this, this.canvas);
    this.time = 0;
    this.isPlaying = false;
    this.loops = true;
    this.follows = false;
    this.isBare = false;
    // The first picture is a quick one.
    this.finest = 0.7;
    this.movedAt = performance.now();
    this.drawnAt = -PART_INTERVAL;
    this.wasWhole = false;
    this.drawn = null;
    /** A picture that is drawn in steps. */
    this.refining = null;
    this.stepsAtATime = 1;
    this.pictures = 0;
    this.isAwake = false;
    this.decoded = new Set();
    /** What stands for the loading that goes on, if any does. */
    this.loading = null;
    this.takeAddress();
    this.fillPage();
    const wake = () => this.wake();
    window.addEventListener("resize", wake);
    window.addEventListener("hashchange", () => {
      if (location.hash !== this.fragment) this.takeAddress();
    });
    document.addEventListener("fullscreenchange", () => {
      element("full").setAttribute("aria-pressed", String(Boolean(document.fullscreenElement)));
      wake();
    });
  }

  get frame() {
    return Math.min(Math.floor(this.time), this.scene.frames.length - 1);
  }

  // What the page shows beside the picture.

  fillPage() {
    const { scene } = this;
    const click = (id, does) => element(id).addEventListener("click", does);
    click("play", () => this.togglePlay());
    click("loop", () => this.toggleLoop());
    click("follow", () => this.toggleFollow());
    click("home", () => this.goHome());
    click("help", () => this.showHelp());
    click("full", () => this.toggleFullScreen());
    click("link", () => this.copyAddress());
    element("link").hidden = location.protocol === "about:";
    element("frame").max = scene.frames.length - 1;
    element("frame").addEventListener("input", (event) => this.seek(Number(event.target.value)));
    document.body.classList.toggle("still", scene.frames.length < 2);
    element("follow").hidden = !scene.path;
    document.querySelectorAll(".of-path").forEach((part) => { part.hidden = !scene.path; });
    const choice = element("camera");
    scene.cameras.forEach((camera, nth) => choice.add(new Option(camera.name, String(nth))));
    choice.addEventListener("change", () => choice.value !== "" && this.goToCamera(Number(choice.value)));
    for (const text of scene.paragraphs) element("text").append(Object.assign(document.createElement("p"), { textContent: text }));
    if (scene.scalar_bar) this.fillScalarBar(scene.scalar_bar);
    element("story").hidden = scene.paragraphs.length === 0;
    element("story").open = innerWidth > 720 && innerHeight > 560;
    this.canvas.setAttribute("aria-label", scene.title);
    if (!root.requestFullscreen) element("full").hidden = true;
    this.showTime();
  }

  /** What the colors mean, where they are those of a value. */
  fillScalarBar({ title, colors, ticks }) {
    const [caption, bar, marks] = element("scale").children;
    caption.textContent = title;
    bar.style.background = `linear-gradient(to right, ${colors.map((color) => `rgb(${color.join(" ")})`).join()})`;
    element("scale").hidden = false;
    let free = -Infinity;
    for (const [share, text] of ticks) {
      const mark = Object.assign(document.createElement("span"), { textContent: text });
      mark.style.left = `${100 * share}%`;
      mark.style.translate = `${-100 * share}%`;
      marks.append(mark);
      const { left, right } = mark.getBoundingClientRect();
      if (left < free) mark.remove();
      else free = right + 8;
    }
  }

  showTime() {
    const { frames } = this.scene;
    const number = frames[this.frame];
    element("frame").value = this.frame;
    element("frame").setAttribute("aria-valuetext", `frame ${number}, ${this.frame + 1} of ${frames.length}`);
    element("number").textContent = `${number} / ${frames.at(-1)}`;
  }

  say(text) {
    element("said").textContent = text;
  }

  // Commands.

  togglePlay() {
    this.isPlaying = !this.isPlaying && this.scene.frames.length > 1;
    if (this.isPlaying && !this.loops && this.time >= this.scene.frames.length - 1) this.time = 0;
    document.body.classList.toggle("playing", this.isPlaying);
    element("play").setAttribute("aria-label", this.isPlaying ? "Pause" : "Play");
    this.say(this.isPlaying ? "Playing" : `Paused at frame ${this.scene.frames[this.frame]}`);
    this.lastTick = undefined;
    this.wake();
  }

  toggleLoop() {
    this.loops = !this.loops;
    element("loop").setAttribute("aria-pressed", String(this.loops));
    this.say(this.loops ? "Looping" : "Not looping");
  }

  toggleFollow(follows = !this.follows) {
    this.follows = follows && Boolean(this.scene.path);
    element("follow").setAttribute("aria-pressed", String(this.follows));
    if (this.follows) {
      this.say("Following the camera path");
      if (!this.isPlaying) this.togglePlay();
    }
    this.wake();
  }

  toggleFullScreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else root.requestFullscreen?.().catch(() => this.say("Full screen is not allowed here"));
  }

  showHelp() {
    element("keys").showModal();
  }

  seek(frame) {
    this.time = Math.min(Math.max(frame, 0), this.scene.frames.length - 1);
    this.showTime();
    this.wake();
  }

  step(by) {
    if (this.isPlaying) this.togglePlay();
    const count = this.scene.frames.length;
    this.seek(this.loops ? (this.frame + by + count) % count : this.frame + by);
  }

  goHome() {
    this.move((view) => view.home());
    this.say("First view");
  }

  goToCamera(index) {
    this.move((view) => view.atCamera(index));
    element("camera").value = String(index);
    this.say(`At camera ${this.scene.cameras[index].name}`);
  }

  /** Changes the view by `change`; who moves it by hand leaves the path. */
  move(change) {
    if (this.follows) this.toggleFollow(false);
    element("camera").value = "";
    change(this.view);
    this.movedAt = performance.now();
    this.wake();
  }

  /** The point of the scene at a place in the window; null where nothing near is shown. */
  pointAt(clientX, clientY) {
    if (!this.drawn) return null;
    const { pose, lens } = this.drawn;
    const [x, y] = [clientX / this.canvas.clientWidth * lens[0], clientY / this.canvas.clientHeight * lens[1]];
    return pointOf(pose, lens, x, y, this.renderer.inverseDepthAt(x, y));
  }

  // The address.

  takeAddress() {
    const found = readFragment(location.hash, this.scene);
    this.isBare = found.isBare;
    document.body.classList.toggle("bare", found.isBare);
    if (found.frame !== undefined) this.time = found.frame;
    if (found.pose) {
      this.view.at(found.pose, found.lens);
      this.view.pivotDistance = found.pivotDistance ?? this.view.pivotDistance;
    } else if (found.lens) {
      this.view.lens = found.lens;
    }
    this.showTime();
    this.wake();
  }

  currentAddress() {
    return fragmentOf(this.view, this.scene, this.scene.frames[this.frame], this.isBare);
  }

  keepAddress() {
    this.fragment = this.currentAddress();
    // Within another document, as in a notebook, the address is that one's.
    if (location.hash === this.fragment || location.protocol === "about:") return;
    try {
      history.replaceState(null, "", this.fragment);
    } catch {
      location.replace(this.fragment);
    }
  }

  async copyAddress() {
    this.keepAddress();
    try {
      await navigator.clipboard.writeText(location.href);
      this.say("The address of this view is on the clipboard");
      element("link").classList.add("done");
      setTimeout(() => element("link").classList.remove("done"), 1200);
    } catch {
      element("address-text").value = location.href;
      element("address").showModal();
      element("address-text").select();
    }
  }

  // Pictures.

  /** Draws as long as something changes. */
  wake() {
    if (this.isAwake) return;
    this.isAwake = true;
    this.lastTick = undefined;
    requestAnimationFrame((now) => this.tick(now));
  }

  tick(now) {
    const passed = this.lastTick === undefined ? 0 : now - this.lastTick;
    this.lastTick = now;
    if (this.controls.isFlying()) this.controls.fly(passed / 1000);
    if (this.isPlaying) this.passTime(passed / 1000);
    if (this.follows) this.followPath();
    const isFirst = this.pictures === 0;
    const moves = this.isPlaying || this.controls.isFlying() || this.controls.isDragging() || performance.now() - this.movedAt < REST;
    if (moves && passed > 0) this.adapt(passed);
    if (!moves && !isFirst) roundView(this.view);
    const isShown = this.show(moves || isFirst ? this.finest : null);
    if (moves || isFirst || !isShown && (this.loading || this.refining)) {
      requestAnimationFrame((later) => this.tick(later));
      return;
    }
    this.isAwake = false;
    if (isShown && !this.isBare) this.keepAddress();
  }

  passTime(seconds) {
    const [first, end] = this.follows
      ? [this.scene.path.first_frame, this.scene.path.first_frame + this.scene.path.poses.length]
      : [0, this.scene.frames.length];
    this.time = Math.max(this.time + seconds * this.scene.frames_per_second, first);
    if (this.time >= end) {
      this.time = this.loops ? first + (this.time - first) % (end - first) : end - 1;
      if (!this.loops) this.togglePlay();
    }
    this.showTime();
  }

  followPath() {
    const { first_frame: first, poses, lens } = this.scene.path;
    const at = Math.min(Math.max(this.time - first, 0), poses.length - 1);
    const before = Math.floor(at);
    this.view.at(between(poses[before], poses[Math.min(before + 1, poses.length - 1)], at - before), lens);
  }

  /** Coarser pictures where the device is slow, finer ones where it is fast. */
  adapt(milliseconds) {
    this.pace = 0.7 * (this.pace ?? 50) + 0.3 * Math.min(milliseconds, 400);
    if (this.pace > SLOW && this.finest > COARSEST) {
      this.finest = Math.max(this.finest * Math.max(Math.sqrt(SLOW / this.pace), 0.6), COARSEST);
      this.pace = 50;
    } else if (this.pace < FAST && this.finest < FINEST) {
      this.finest = Math.min(this.finest * 1.25, FINEST);
      this.pace = 50;
    }
  }

  /**
   * Draws what is to be seen, unless that is on the screen already; false while it, or samples of it, are on their way. Until the first
   * frame is whole, it is drawn from what is there of it. `finest` is null at rest: the picture is as fine as it can be then.
   */
  show(finest) {
    const isWhole = this.missing().length === 0;
    if (!this.renderer || this.renderer.canvas.gl.isContextLost() || !isWhole && !this.isPartTime()) return false;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight].map((side) => Math.max(Math.round(side * ratio), 1));
    const lens = this.view.pictureLens(width, height, finest ?? FINEST);
    const { pose } = this.view;
    const { drawn, frame } = this;
    const isFinal = finest === null;
    const isSame = (a) => a?.frame === frame && [...pose, ...lens].every((part, nth) => part === [...a.pose, ...a.lens][nth]);
    if (drawn?.isWhole && (drawn.isFinal || !isFinal) && isSame(drawn)) return true;
    const picture = { frame, pose, lens, isWhole, isFinal };
    if (isFinal) return this.renderer.isReady && this.refine(picture, isSame);
    this.refining = null;
    const isStill = this.isPlaying && isSame({ ...drawn, frame });
    const coarser = FEWER_SAMPLES.filter((few) => finest < few).length;
    this.renderer.draw(frame, pose, lens, { isStill, coarser: this.renderer.isReady ? coarser : Math.max(coarser, 1) });
    this.took(picture);
    return isWhole;
  }

  /** Draws some more of a picture at rest; whether it is there. */
  refine(picture, isSame) {
    const now = performance.now();
    if (!isSame(this.refining?.picture) || this.refining.picture.isWhole !== picture.isWhole) {
      const { frame, pose, lens } = picture;
      const steps = this.renderer.steps(frame, pose, lens, { subpixels: this.view.subpixels(lens), isFinal: true });
      this.refining = { picture, steps, since: now };
    } else if (!this.renderer.canvas.isIdle()) {
      return false;
    } else if (now - this.refining.since < SHORT_STEPS) {
      this.stepsAtATime *= 2;
    } else if (now - this.refining.since > LONG_STEPS) {
      this.stepsAtATime = Math.max(this.stepsAtATime / 2, 1);
    }
    this.refining.since = now;
    for (let nth = 0; nth < this.stepsAtATime; nth++) {
      if (!this.refining.steps.next().done) continue;
      this.refining = null;
      this.took(picture);
      return picture.isWhole;
    }
    this.renderer.canvas.watch();
    return false;
  }

  /** Says that a picture is on the screen. */
  took(picture) {
    this.drawn = picture;
    this.drawnAt = performance.now();
    this.wasWhole ||= picture.isWhole;
    this.pictures += 1;
    if (this.pictures === 1) {
      root.dataset.state = "ready";
      root.dataset.firstPicture = String(Math.round(performance.now()));
    }
    const { frame, lens } = picture;
    Object.assign(root.dataset, { frame: this.scene.frames[frame], pictures: this.pictures, size: `${lens[0]}×${lens[1]}` });
  }

  /** Whether a picture of a part of the first frame is due: some of it is there, and the last such picture is old. */
  isPartTime() {
    if (this.wasWhole || performance.now() - this.drawnAt < PART_INTERVAL) return false;
    const { chunks } = this.scene;
    return [...this.decoded].some((nth) => chunks[nth].some((image) => this.isAlive(image)));
  }

  /** Forgets all that the device drew with: it has taken it back, as phones do from pages that are not looked at. */
  lose() {
    this.renderer = null;
    this.refining = null;
    this.drawn = null;
    this.loading = null;
    delete root.dataset.loaded;
  }

  // Samples.

  /** The chunks that the current frame still needs. */
  missing() {
    const isSeen = (image) => this.isAlive(image);
    return this.scene.chunks.flatMap((images, nth) => !this.decoded.has(nth) && images.some(isSeen) ? [nth] : []);
  }

  /** Whether an image is part of the current frame. */
  isAlive({ start, end }) {
    return start <= this.frame && this.frame < end;
  }
}

function fail(error) {
  root.dataset.state = "failed";
  const reason = error instanceof CannotDraw ? error.message : `The scene cannot be shown: ${error.message}.`;
  element("message").textContent = reason;
  element("message").hidden = false;
}

function start() {
  const player = new Player(JSON.parse(element("scene").textContent));
  player.canvas.addEventListener("webglcontextlost", (event) => {
    // Without this the device never gives it back.
    event.preventDefault();
    player.lose();
  });
  player.canvas.addEventListener("webglcontextrestored", () => load(player).catch(fail));
  window.overlook = player;
  load(player).catch(fail);
}

if (!servesAsDecoder()) {
  try {
    start();
  } catch (error) {
    fail(error);
  }
}
