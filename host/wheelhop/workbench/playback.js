// A run played back: the vehicle from the side, as measured and as modelled, over its track.
// `play` is given a canvas's neighbours by the id of the element around them, and what to draw.
window.wheelhop = window.wheelhop || {};

wheelhop.playback = (root, data) => {
  const at = (name) => root.querySelector(`[data-part=${name}]`);
  const [canvas, button, slider, pace, clock] =
    ["canvas", "toggle", "time", "pace", "clock"].map(at);
  const duration = (data.position_m.length - 1) / data.rate_hz;
  let now = 0, last = null, playing = false;
  slider.max = duration;

  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const sample = (values, time) => {
    const i = Math.min(Math.floor(time * data.rate_hz), values.length - 2);
    const part = time * data.rate_hz - i;
    return values[i] * (1 - part) + values[i + 1] * part;
  };
  const ground = (x) => {
    if (!data.ground_m.length) return 0;
    const place = (x - data.ground_from_m) / data.ground_step_m;
    const i = Math.max(0, Math.min(Math.floor(place), data.ground_m.length - 2));
    return data.ground_m[i] + (place - i) * (data.ground_m[i + 1] - data.ground_m[i]);
  };

  const draw = () => {
    const box = canvas.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    canvas.width = box.width * ratio;
    canvas.height = box.height * ratio;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = "13px sans-serif";
    const width = box.width / data.views.length;
    data.views.forEach((view, k) => {
      pen.save();
      pen.beginPath();
      pen.rect(k * width, 0, width, box.height);
      pen.clip();
      pen.translate(k * width, 0);
      panel(pen, view, width, box.height);
      pen.restore();
    });
    slider.value = now;
    const last_s = data.start_s + duration;
    clock.textContent = `${(data.start_s + now).toFixed(2)} of ${last_s.toFixed(2)} s`;
  };

  const panel = (pen, view, width, height) => {
    const scale = width / (data.wheelbase_m + 2.2);
    const lift = scale * data.exaggeration;
    const road = height - 46;
    const front_m = sample(data.position_m, now);
    const px = (x) => width / 2 + (x - front_m + data.wheelbase_m / 2) * scale;
    pen.strokeStyle = colour("ink");
    pen.lineWidth = 1.5;
    pen.beginPath();
    for (let i = 0; i <= width; i += 2) {
      const x = front_m - data.wheelbase_m / 2 + (i - width / 2) / scale;
      pen.lineTo(i, road - lift * ground(x));
    }
    pen.stroke();
    if (view.behind) vehicle(pen, view.behind, px, road, scale, lift, colour("soft"), true);
    vehicle(pen, view, px, road, scale, lift, colour(view.colour), false);
    pen.fillStyle = colour(view.colour);
    pen.fillText(view.name, 12, 20);
    pen.fillStyle = colour("soft");
    if (view.behind) pen.fillText("dashed: measured", 12, 38);
    const metre = Math.ceil(front_m - width / 2 / scale - data.wheelbase_m / 2);
    for (let x = metre; px(x) < width; x++) {
      pen.fillRect(px(x), height - 34, 1, 6);
      pen.fillText(`${x} m`, px(x) + 4, height - 22);
    }
  };

  const vehicle = (pen, view, px, road, scale, lift, stroke, dashed) => {
    const front_m = sample(data.position_m, now);
    const points = ["front", "rear"].map((end, i) => {
      const axle = view.axle[end], body = view.body[end];
      return {
        x: px(front_m - i * data.wheelbase_m),
        wheel: axle && road - scale * data.radius_m - lift * sample(axle, now),
        body: body && road - scale * data.body_m - lift * sample(body, now),
      };
    });
    pen.strokeStyle = stroke;
    pen.setLineDash(dashed ? [4, 4] : []);
    pen.lineWidth = dashed ? 1.2 : 2.2;
    for (const { x, wheel, body } of points) {
      if (wheel !== undefined) circle(pen, x, wheel, scale * data.radius_m);
      if (wheel !== undefined && body !== undefined) spring(pen, x, wheel, body);
    }
    const [front, rear] = points;
    if (front.body !== undefined && rear.body !== undefined) shell(pen, front, rear, scale);
    pen.setLineDash([]);
  };

  const circle = (pen, x, y, radius) => {
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.stroke();
    pen.beginPath();
    pen.arc(x, y, 2, 0, 2 * Math.PI);
    pen.stroke();
  };

  const spring = (pen, x, wheel, body) => {
    pen.beginPath();
    pen.moveTo(x, wheel);
    for (let i = 1; i < 8; i++) pen.lineTo(x + (i % 2 ? 5 : -5), wheel + ((body - wheel) * i) / 8);
    pen.lineTo(x, body);
    pen.stroke();
  };

  const shell = (pen, front, rear, scale) => {
    const long = front.x - rear.x, slope = (front.body - rear.body) / long;
    const place = (along, up) => [
      rear.x + along * long - slope * -up * scale,
      rear.body + slope * along * long - up * scale,
    ];
    const outline = [[-0.18, 0], [-0.18, 0.16], [0.22, 0.2], [0.36, 0.46], [0.62, 0.46],
      [0.8, 0.2], [1.16, 0.14], [1.18, 0]];
    pen.beginPath();
    outline.forEach(([along, up]) => pen.lineTo(...place(along, up)));
    pen.closePath();
    pen.stroke();
  };

  const step = (stamp) => {
    if (!playing || !root.isConnected) return;
    if (last !== null) now += ((stamp - last) / 1000) * Number(pace.value);
    last = stamp;
    if (now >= duration) now = 0;
    draw();
    requestAnimationFrame(step);
  };
  const play = (on) => {
    playing = on;
    last = null;
    button.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(step);
  };
  if (root.stop) root.stop();
  root.stop = () => play(false);
  button.onclick = () => play(!playing);
  slider.oninput = () => { now = Number(slider.value); draw(); };
  play(false);
  draw();
};
