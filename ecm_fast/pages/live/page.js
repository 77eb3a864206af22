"use strict";
// One request is under way at a time. Whatever moves meanwhile only changes what is wanted; the next request asks for
// the newest. A reply is drawn when it comes: what the screen shows next is the newest pose there is.

const view = { sent: 0, received: 0, drawn: 0, frame: null, frameUs: [] };
window.view = view;
const at = (id) => document.getElementById(id);
const canvas = at("picture"), pen = canvas.getContext("2d");
const sliders = new Map();
let socket, hello, cloud = [], wanted = false, wish = null, under = false, times = [];

// ------------------------------------------------------------------ talking

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.onmessage = (event) => take(JSON.parse(event.data));
  socket.onclose = () => {
    verdict("the program has ended, or is being restarted", true);
    under = false;
    setTimeout(connect, 1000);
  };
}

function take(reply) {
  if (reply.controls) {
    greet(reply);
    return;
  }
  under = false;
  at("complaint").textContent = reply.error || "";
  if (!reply.error) {
    view.received = reply.id;
    view.frame = reply;
    view.frameUs.push(reply.frame_us);
    if (reply.workspace) cloud = reply.workspace;
    draw();
    tell();
  }
  ask();
}

function want(place) {
  wanted = true;
  wish = place || null;
  ask();
}

function ask() {
  if (!wanted || under || !socket || socket.readyState !== WebSocket.OPEN) return;
  const request = { id: ++view.sent, inputs: {} };
  for (const [name, slider] of sliders) request.inputs[name] = slider.value;
  if (wish) request.wish = wish;
  wanted = false;
  under = true;
  socket.send(JSON.stringify(request));
}

// ------------------------------------------------------------------ sliders

function greet(reply) {
  const first = !hello;
  hello = reply;
  document.querySelector(".data").hidden = !hello.measured.length;
  if (first) for (const control of hello.controls) addSlider(control);
  want();
}

function addSlider(control) {
  const label = document.createElement("label"), output = document.createElement("output");
  const input = document.createElement("input");
  Object.assign(input, { type: "range", min: 0, max: 400, step: 1, name: control.name });
  label.append(control.label, output, input);
  at(control.group).append(label);
  const slider = {
    control, value: control.value,
    set(value) {
      slider.value = value;
      input.value = Math.round((400 * (value - control.low)) / (control.high - control.low));
      const shown = `${Number(value.toPrecision(4))} ${control.unit}`;
      output.textContent = shown;
      input.setAttribute("aria-valuetext", shown);
    },
  };
  input.addEventListener("input", () => {
    slider.set(control.low + ((control.high - control.low) * input.value) / 400);
    want();
  });
  slider.set(control.value);
  sliders.set(control.name, slider);
}

at("reset").addEventListener("click", () => {
  for (const slider of sliders.values()) slider.set(slider.control.value);
  want();
});

// ------------------------------------------------------------------ dragging

const load = { perMetre: () => 60 / length(), lever: () => 0.22 * length() };

function length() {
  return sliders.get("beam.length").control.value;
}

function scale() {
  const box = canvas.getBoundingClientRect();
  const metre = Math.min(box.height / (1.75 * length()), box.width / (2.4 * length()));
  return { metre, left: box.width / 2, bottom: box.height - 0.22 * length() * metre, box };
}

function toScreen([x, z], s) {
  return [s.left - z * s.metre, s.bottom - x * s.metre];
}

function toPlace(event) {
  const s = scale();
  return [(s.box.top + s.bottom - event.clientY) / s.metre, (s.box.left + s.left - event.clientX) / s.metre];
}

function loadBase(pose) {
  return [pose[0] + load.lever() * Math.cos(pose[2]), pose[1] - load.lever() * Math.sin(pose[2])];
}

function setLoad(place) {
  const base = loadBase(view.frame.pose), ends = ["fx", "fz"];
  ends.forEach((name, i) => {
    const { low, high } = sliders.get(name).control;
    sliders.get(name).set(Math.min(high, Math.max(low, (place[i] - base[i]) * load.perMetre())));
  });
  want();
}

const arrows = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };

function makeHandle(button, moveTo, moveBy) {
  let grip = null;
  button.addEventListener("pointerdown", (event) => {
    if (!view.frame || !view.frame.pose) return;
    const place = toPlace(event), own = JSON.parse(button.dataset.place);
    grip = [own[0] - place[0], own[1] - place[1]];
    button.setPointerCapture(event.pointerId);
    button.focus();
    event.preventDefault();
  });
  button.addEventListener("pointermove", (event) => {
    if (!grip || !view.frame.pose) return;
    const place = toPlace(event);
    moveTo([place[0] + grip[0], place[1] + grip[1]]);
  });
  for (const end of ["pointerup", "pointercancel"]) button.addEventListener(end, () => { grip = null; });
  button.addEventListener("keydown", (event) => {
    const way = arrows[event.key];
    if (!way || !view.frame || !view.frame.pose) return;
    moveBy(way);
    event.preventDefault();
  });
}

makeHandle(at("head"), (place) => want(place), (way) => {
  const pose = view.frame.pose;
  want([pose[0] + 0.001 * way[0], pose[1] + 0.001 * way[1]]);
});
makeHandle(at("load"), setLoad, (way) => {
  ["fx", "fz"].forEach((name, i) => {
    const { control, value, set } = sliders.get(name);
    set(Math.min(control.high, Math.max(control.low, value + way[i])));
  });
  want();
});

// ------------------------------------------------------------------ drawing

function line(points, color, width, dash) {
  pen.beginPath();
  points.forEach(([px, py], i) => (i ? pen.lineTo(px, py) : pen.moveTo(px, py)));
  pen.setLineDash(dash || []);
  pen.strokeStyle = color;
  pen.lineWidth = width;
  pen.stroke();
}

function dots(places, s, color, size) {
  pen.fillStyle = color;
  for (const place of places) {
    const [px, py] = toScreen(place, s);
    pen.fillRect(px - size / 2, py - size / 2, size, size);
  }
}

function colors() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(["ink", "faint", "fem", "poly", "cloud", "data", "bad"].map((name) => [name, style.getPropertyValue(`--${name}`)]));
}

function draw() {
  const s = scale(), color = colors(), sharp = window.devicePixelRatio || 1, frame = view.frame;
  const [width, height] = [Math.round(s.box.width * sharp), Math.round(s.box.height * sharp)];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  pen.setTransform(sharp, 0, 0, sharp, 0, 0);
  pen.clearRect(0, 0, s.box.width, s.box.height);
  line([[0, s.bottom], [s.box.width, s.bottom]], color.faint, 1);
  if (frame.pose) drawBlock(frame, s, color);
  dots(cloud, s, color.cloud, 3);
  dots(hello.measured, s, color.data, 5);
  for (const button of [at("head"), at("load")]) button.hidden = !frame.pose;
  if (frame.pose) drawNeck(frame, s, color);
  view.drawn = frame.id;
  count();
}

function drawBlock(frame, s, color) {
  pen.globalAlpha = 0.25;
  pen.lineCap = "butt";
  line(frame.outline.beam.map((point) => toScreen(point, s)), color.faint, 0.3 * length() * s.metre);
  pen.globalAlpha = 1;
}

function drawNeck(frame, s, color) {
  const lines = frame.outline, put = (points) => points.map((point) => toScreen(point, s));
  pen.lineCap = "round";
  lines.tendons.forEach((points) => line(put(points), color.ink, 1.5));
  lines.pulleys.forEach((center) => {
    const [px, py] = toScreen(center, s);
    pen.beginPath();
    pen.arc(px, py, Math.max(3, lines.radius * s.metre), 0, 7);
    pen.stroke();
  });
  line(put(lines.beam), frame.stable ? color.fem : color.bad, 3);
  line(put(lines.plate), color.ink, 6);
  line(put([frame.pose, lines.mass]), color.faint, 1);
  dots([lines.mass], s, color.ink, 8);
  if (frame.polynomial) {
    const [x, z, theta] = frame.polynomial.pose, away = 0.35 * length();
    const plate = [1, -1].map((side) => [x + side * away * Math.sin(theta), z + side * away * Math.cos(theta)]);
    line(put(plate), color.poly, 2, [6, 4]);
  }
  const base = loadBase(frame.pose);
  const tip = ["fx", "fz"].map((name, i) => base[i] + sliders.get(name).value / load.perMetre());
  line(put([base, tip]), color.bad, 2);
  move(at("head"), frame.pose, s);
  move(at("load"), tip, s);
}

function move(button, place, s) {
  const [px, py] = toScreen(place, s);
  button.dataset.place = JSON.stringify([place[0], place[1]]);
  button.style.transform = `translate(${px}px, ${py}px)`;
}

// ------------------------------------------------------------------ figures

function verdict(text, bad) {
  if (at("verdict").textContent !== text) at("verdict").textContent = text;
  at("verdict").className = bad ? "bad" : "";
}

function tell() {
  const frame = view.frame, pose = frame.pose, off = frame.polynomial;
  ["lam_l", "lam_r"].forEach((name, i) => {
    if (!wanted && frame.lam[i] !== Number(sliders.get(name).value.toFixed(6))) sliders.get(name).set(frame.lam[i]);
  });
  verdict(frame.message, !frame.stable);
  at("place").textContent = pose ? `${(1e3 * pose[0]).toFixed(2)} mm, ${(1e3 * pose[1]).toFixed(2)} mm` : "-";
  at("angle").textContent = pose ? `${((180 / Math.PI) * pose[2]).toFixed(2)}\u00b0` : "-";
  at("off").textContent = off ? `${off.mm.toFixed(4)} mm, ${off.mrad.toFixed(3)} mrad` : "-";
  at("times").textContent = `${frame.step_us.toFixed(2)} \u00b5s, ${frame.solve_us.toFixed(0)} \u00b5s`;
}

function count() {
  const now = performance.now();
  times = times.filter((then) => now - then < 1000);
  times.push(now);
  at("rate").textContent = times.length;
}

window.addEventListener("resize", () => view.frame && draw());
connect();
