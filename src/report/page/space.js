// Cells in space, drawn by WebGL: shaded, turned by pointer and keys; the cell under the pointer is found by
// drawing the numbers of cells into one pixel.

/// Toward the light from a viewer that looks as in src/plot/z_buffer.rs: to the right, up, toward the viewer.
const LIGHT = [-0.07, 0.385, 0.92];

const VERTEX_SHADER = `
attribute vec3 place;
attribute vec3 normal;
attribute vec3 color;
attribute vec3 cell;
uniform mat4 view;
uniform vec4 cut;
uniform vec3 light;
uniform vec3 chosen;
uniform float nearer;
varying vec3 tint;
varying vec3 number;
varying float beyond;
void main() {
  gl_Position = view * vec4(place, 1.0);
  gl_Position.z -= nearer;
  beyond = dot(cut.xyz, place) - cut.w;
  float shade = min(1.0, 0.56 + 0.46 * max(0.0, dot(normal, light)));
  tint = shade * color;
  if (distance(cell, chosen) < 0.002) tint = mix(tint, vec3(1.0), 0.5);
  number = cell;
}`;

const FRAGMENT_SHADER = `
#ifdef GL_FRAGMENT_PRECISION_HIGH
precision highp float;
#else
precision mediump float;
#endif
uniform vec4 ink;
uniform float mode;
uniform float slack;
varying vec3 tint;
varying vec3 number;
varying float beyond;
void main() {
  if (beyond > slack) discard;
  gl_FragColor = mode < 0.5 ? vec4(tint, 1.0) : mode < 1.5 ? vec4(ink.rgb * ink.a, ink.a) : vec4(number, 1.0);
}`;

const ATTRIBUTES = { place: [3, 0], normal: [3, 12], color: [3, 16], cell: [3, 20] };

class SpaceView {
  /// Draws into `canvas`; throws where the browser has no WebGL.
  constructor(canvas, toward) {
    this.canvas = canvas;
    this.camera = new Camera(toward);
    const wanted = { antialias: true, alpha: true, preserveDrawingBuffer: true };
    this.gl = canvas.getContext("webgl2", wanted) ?? canvas.getContext("webgl", wanted);
    if (!this.gl) throw new Error("this browser has no WebGL");
    this.chosen = -1;
    this.outlines = true;
    this.prepare();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
      this.prepare();
      this.show(this.surface, this.cut);
    });
  }

  prepare() {
    const { gl } = this;
    this.program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX_SHADER], [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) {
      throw new Error(`WebGL refuses the shaders: ${gl.getProgramInfoLog(this.program)}`);
    }
    gl.useProgram(this.program);
    const names = ["view", "cut", "light", "chosen", "nearer", "ink", "mode", "slack"];
    this.uniforms = Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(this.program, name)]));
    this.places = Object.fromEntries(Object.keys(ATTRIBUTES).map((name) => [name, gl.getAttribLocation(this.program, name)]));
    this.buffers = { faces: gl.createBuffer(), lines: gl.createBuffer(), box: gl.createBuffer() };
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.preparePixel();
  }

  /// The frame of one pixel into which numbers of cells are drawn.
  preparePixel() {
    const { gl } = this;
    this.pixel = gl.createFramebuffer();
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    const depth = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT16, 1, 1);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.pixel);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /// The cells whose box is to be looked at.
  aim(cells) {
    const corners = cells.bounds.map((corner) => corner.map((x, axis) => x - cells.origin[axis]));
    const [min, max] = corners;
    this.middle = min.map((x, axis) => 0.5 * (x + max[axis]));
    this.extent = max.map((x, axis) => x - min[axis]);
    this.radius = 0.52 * Math.hypot(...this.extent);
    this.cellSide = Math.cbrt(this.extent.reduce((product, x) => product * x, 1) / cells.total);
    this.corners = corners;
  }

  /// The edges of the box but for the three that meet in front.
  boxEdges() {
    const front = this.camera.axes()[2].map((part) => (part > 0 ? 1 : 0));
    const box = [];
    for (let axis = 0; axis < 3; axis++) {
      const others = planeAxes(axis);
      for (let side = 0; side < 4; side++) {
        const ends = others.map((_, k) => (side >> k) & 1);
        if (ends.every((end, k) => end === front[others[k]])) continue;
        for (const end of [0, 1]) {
          const corner = [end, end, end];
          others.forEach((other, k) => {
            corner[other] = ends[k];
          });
          box.push(...corner.map((k, at) => this.corners[k][at]));
        }
      }
    }
    return new Float32Array(box);
  }

  show(surface, cut) {
    const { gl } = this;
    this.surface = surface;
    this.cut = cut;
    const fill = (buffer, data) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    };
    fill(this.buffers.faces, surface.bytes.subarray(0, surface.count * VERTEX_BYTES));
    fill(this.buffers.lines, new Float32Array(surface.lines));
    this.draw();
  }

  /// Draws at the next opportunity.
  draw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.drawNow();
    });
  }

  /// Width and height in the page's pixels.
  size() {
    return [this.canvas.clientWidth || 1, this.canvas.clientHeight || 1];
  }

  drawNow() {
    const { gl, canvas } = this;
    if (!this.surface || gl.isContextLost()) return;
    const [width, height] = this.size();
    const fineness = Math.min(window.devicePixelRatio || 1, 3);
    const wanted = [width, height].map((length) => Math.round(length * fineness));
    if (canvas.width !== wanted[0] || canvas.height !== wanted[1]) [canvas.width, canvas.height] = wanted;
    gl.viewport(0, 0, ...wanted);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.setUniforms(null);
    this.drawFaces(0);
    gl.enable(gl.BLEND);
    gl.uniform1f(this.uniforms.mode, 1);
    const side = this.camera.scale(this.radius, width, height) * this.cellSide;
    if (this.outlines) this.drawLines(this.buffers.lines, this.surface.lines.length / 3, [0.05, 0.05, 0.05, clamp(side / 14, 0.12, 0.8)]);
    gl.uniform4f(this.uniforms.cut, 0, 0, 0, 0);
    const ink = rgbOf(styleColor("--faint")).map((part) => part / 255);
    const box = this.boxEdges();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.box);
    gl.bufferData(gl.ARRAY_BUFFER, box, gl.DYNAMIC_DRAW);
    this.drawLines(this.buffers.box, box.length / 3, [...ink, 0.8]);
    gl.disable(gl.BLEND);
    this.onDraw?.();
  }

  setUniforms(focus) {
    const { gl, uniforms, camera, middle, radius } = this;
    const [width, height] = this.size();
    gl.uniformMatrix4fv(uniforms.view, false, camera.matrix({ middle, radius, width, height, focus }));
    const [right, up, toward] = camera.axes();
    const light = [0, 1, 2].map((k) => LIGHT[0] * right[k] + LIGHT[1] * up[k] + LIGHT[2] * toward[k]);
    gl.uniform3fv(uniforms.light, light);
    const plane = [0, 0, 0, 0];
    if (this.cut) {
      const side = this.cut.keepsBelow ? 1 : -1;
      plane[this.cut.axis] = side;
      plane[3] = side * this.cut.place;
    }
    gl.uniform4fv(uniforms.cut, plane);
    gl.uniform1f(uniforms.slack, 2e-6 * radius);
    const number = this.chosen + 1;
    gl.uniform3f(uniforms.chosen, ...[0, 8, 16].map((shift) => ((number >> shift) & 255) / 255));
  }

  drawFaces(mode) {
    const { gl } = this;
    gl.uniform1f(this.uniforms.mode, mode);
    gl.uniform1f(this.uniforms.nearer, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.faces);
    for (const [name, [length, offset]] of Object.entries(ATTRIBUTES)) {
      const kind = { place: gl.FLOAT, normal: gl.BYTE }[name] ?? gl.UNSIGNED_BYTE;
      gl.enableVertexAttribArray(this.places[name]);
      gl.vertexAttribPointer(this.places[name], length, kind, kind !== gl.FLOAT, VERTEX_BYTES, offset);
    }
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.drawArrays(gl.TRIANGLES, 0, this.surface.count);
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }

  drawLines(buffer, count, ink) {
    const { gl, places } = this;
    gl.uniform4fv(this.uniforms.ink, ink);
    gl.uniform1f(this.uniforms.nearer, 4e-4);
    for (const name of ["normal", "color", "cell"]) gl.disableVertexAttribArray(places[name]);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.vertexAttribPointer(places.place, 3, gl.FLOAT, false, 0, 0);
    gl.drawArrays(gl.LINES, 0, count);
  }

  /// The cell at a pixel of the page, −1 for none.
  cellAt(x, y) {
    const { gl } = this;
    if (!this.surface || gl.isContextLost()) return -1;
    const color = new Uint8Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.pixel);
    gl.viewport(0, 0, 1, 1);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.setUniforms([x, y]);
    this.drawFaces(2);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, color);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return (color[0] | (color[1] << 8) | (color[2] << 16)) - 1;
  }

  turn(right, up) {
    this.camera.look(this.camera.azimuth - 0.01 * right, this.camera.elevation + 0.01 * up);
    this.draw();
  }

  move(right, down) {
    this.camera.pan = [this.camera.pan[0] + right, this.camera.pan[1] - down];
    this.draw();
  }

  /// Zooms about a pixel of the page.
  magnify(factor, [x, y] = this.size().map((length) => 0.5 * length)) {
    const [width, height] = this.size();
    const zoom = clamp(this.camera.zoom * factor, 0.2, 200);
    const change = zoom / this.camera.zoom;
    const arm = [x - 0.5 * width, 0.5 * height - y];
    this.camera.pan = this.camera.pan.map((length, k) => arm[k] + change * (length - arm[k]));
    this.camera.zoom = zoom;
    this.draw();
  }

  home() {
    this.camera.reset();
    this.draw();
  }

  /// Pixels per unit of length, and where the axes point in the picture.
  compass() {
    const [right, up] = this.camera.axes();
    const axes = [0, 1, 2].map((axis) => [right[axis], -up[axis]]);
    return { scale: this.camera.scale(this.radius, ...this.size()), axes };
  }
}
