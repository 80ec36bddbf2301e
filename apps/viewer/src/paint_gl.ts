// SPDX-License-Identifier: Apache-2.0
// The view through WebGL2: float textures, one rectangle for each pane.
import {kMagma, samplesOf, type Frame, type Painter, type Pane, type Shown} from "./frame";
import type {Panel} from "./panel";
import type {Light} from "./pictures";

const kVertex = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4. - 1., 0, 1); }`;

const kFragment = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D light_a, light_b, terms, magma;
uniform ivec2 scale_a, scale_b;      // values of a display pixel
uniform bool panel_a, panel_b, derives_white;
uniform ivec2 cells, tile;           // of a pixel; cells of a tile
uniform int term_count, mode, samples, canvas_height;
uniform vec2 corner;                 // the picture's, on the canvas
uniform float zoom, exposure, gamma, error_most, gain_a, gain_b;
uniform vec3 background;
out vec4 colour;

vec3 drive(sampler2D tex, ivec2 at) {
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, textureSize(tex, 0)))) return vec3(0);
  return clamp(texelFetch(tex, at, 0).rgb, 0., 1.);
}
vec3 emitted(sampler2D tex, vec2 p) {
  ivec2 cell = ivec2(floor(p * vec2(cells)));
  ivec2 own = cell / cells, in_tile = cell % tile;
  vec3 sum = vec3(0);
  for (int i = 0; i < term_count; ++i) {
    ivec2 at = ivec2(2 * i, in_tile.y * tile.x + in_tile.x);
    vec4 term = texelFetch(terms, at, 0);
    if (term.w < .5) break;
    vec3 rgb = drive(tex, own + ivec2(term.xy));
    float white = min(rgb.r, min(rgb.g, rgb.b));
    float value = term.z > 2.5 ? white : (term.z > 1.5 ? rgb.b : term.z > .5 ? rgb.g : rgb.r) -
      (derives_white ? white : 0.);
    sum += value * texelFetch(terms, at + ivec2(1, 0), 0).rgb;
  }
  return sum;
}
bool light(sampler2D tex, ivec2 scale, bool panel, float gain, vec2 p, out vec3 rgb) {
  ivec2 at = ivec2(floor(p * vec2(scale)));
  rgb = vec3(0);
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, textureSize(tex, 0)))) return false;
  rgb = gain * (panel ? emitted(tex, p) : texelFetch(tex, at, 0).rgb);
  return true;
}
vec3 encode(vec3 v) {
  v = clamp(v * exp2(exposure), 0., 1.);
  if (gamma > 0.) return pow(v, vec3(1. / gamma));
  return mix(12.92 * v, 1.055 * pow(v, vec3(1. / 2.4)) - .055, greaterThan(v, vec3(.0031308)));
}
void main() {
  vec2 here = vec2(gl_FragCoord.x, float(canvas_height) - gl_FragCoord.y) - corner;
  vec3 sum = vec3(0), a, b = vec3(0);
  float error = 0., count = 0.;
  for (int j = 0; j < samples; ++j)
    for (int i = 0; i < samples; ++i) {
      vec2 p = (here + (vec2(i, j) + .5) / float(samples) - .5) / zoom;
      if (!light(light_a, scale_a, panel_a, gain_a, p, a)) continue;
      if (mode > 0 && !light(light_b, scale_b, panel_b, gain_b, p, b)) continue;
      count += 1.;
      sum += a - b;
      error += dot(abs(a - b), vec3(1. / 3.));
    }
  if (count == 0.) colour.rgb = background;
  else if (mode == 0) colour.rgb = encode(sum / count);
  else if (mode == 1) colour.rgb = clamp(.5 + .5 * sum / count / error_most, 0., 1.);
  else colour.rgb = texelFetch(magma, ivec2(round(255. * clamp(error / count / error_most, 0., 1.)), 0), 0).rgb;
  colour.a = 1.;
}`;

type Gl = WebGL2RenderingContext;

function compile(gl: Gl): WebGLProgram {
  const program = gl.createProgram();
  if (!program) throw new Error("WebGL2 makes no program");
  for (const [type, source] of [[gl.VERTEX_SHADER, kVertex], [gl.FRAGMENT_SHADER, kFragment]] as const) {
    const shader = gl.createShader(type) as WebGLShader;
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
      throw new Error(`WebGL2: ${gl.getShaderInfoLog(shader)}`);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`WebGL2: ${gl.getProgramInfoLog(program)}`);
  return program;
}

function makeTexture(gl: Gl): WebGLTexture {
  const texture = gl.createTexture() as WebGLTexture;
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
    gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  return texture;
}

function termTexture(gl: Gl, panel: Panel): WebGLTexture {
  const texture = makeTexture(gl);
  const width = 2 * Math.max(1, panel.most);
  const data = new Float32Array(4 * width * panel.terms.length);
  panel.terms.forEach((terms, row) =>
    terms.forEach((term, i) =>
      data.set([term.dx, term.dy, term.channel, 1, ...term.light, 0], 4 * (row * width + 2 * i)),
    ),
  );
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, width, panel.terms.length, 0, gl.RGBA, gl.FLOAT, data);
  return texture;
}

// Null where there is no WebGL2.
export function makeGlPainter(canvas: HTMLCanvasElement): Painter | null {
  // What was drawn stays readable: people copy and save the canvas.
  const gl = canvas.getContext("webgl2", {alpha: false, antialias: false, preserveDrawingBuffer: true});
  if (!gl) return null;
  const program = compile(gl);
  gl.useProgram(program);
  const at = (name: string): WebGLUniformLocation | null => gl.getUniformLocation(program, name);
  const largest = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
  const magma = makeTexture(gl);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, kMagma);
  const textures = new Map<Light, WebGLTexture>(); // the last few
  const panels = new Map<Panel, WebGLTexture>();
  const none = makeTexture(gl);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 1, 1, 0, gl.RGBA, gl.FLOAT, new Float32Array(4));

  const textureOf = (light: Light): WebGLTexture => {
    const known = textures.get(light);
    if (known) return known;
    if (Math.max(light.width, light.height) > largest)
      throw new Error(`a picture of ${light.width}x${light.height} is too large for WebGL2 here (${largest})`);
    if (textures.size >= 16) {
      const [oldest, texture] = textures.entries().next().value as [Light, WebGLTexture];
      gl.deleteTexture(texture);
      textures.delete(oldest);
    }
    const texture = makeTexture(gl);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB32F, light.width, light.height, 0, gl.RGB, gl.FLOAT, light.rgb);
    textures.set(light, texture);
    return texture;
  };
  const bind = (unit: number, name: string, texture: WebGLTexture): void => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(at(name), unit);
  };
  const bindShown = (unit: number, letter: string, shown: Shown | null, panel: Panel | null): void => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    bind(unit, `light_${letter}`, shown ? textureOf(shown.light) : none);
    gl.uniform2i(at(`scale_${letter}`), shown?.light.scaleX ?? 1, shown?.light.scaleY ?? 1);
    gl.uniform1f(at(`gain_${letter}`), shown?.gain ?? 1);
    gl.uniform1i(at(`panel_${letter}`), shown?.asPanel && panel ? 1 : 0);
  };

  const drawPane = (frame: Frame, pane: Pane): void => {
    bindShown(0, "a", pane.a, frame.panel);
    bindShown(1, "b", pane.b, frame.panel);
    gl.uniform1i(at("mode"), pane.mode === "picture" ? 0 : pane.mode === "difference" ? 1 : 2);
    gl.uniform2f(at("corner"), pane.left, pane.top);
    const x = Math.round(pane.x);
    const y = Math.round(pane.y);
    const width = Math.max(0, Math.round(pane.width));
    const height = Math.max(0, Math.round(pane.height));
    gl.scissor(x, canvas.height - y - height, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  };

  return {
    name: "WebGL2",
    draw(frame) {
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.disable(gl.SCISSOR_TEST);
      gl.clearColor(...frame.background, 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
      gl.enable(gl.SCISSOR_TEST);
      if (frame.panel && !panels.has(frame.panel)) panels.set(frame.panel, termTexture(gl, frame.panel));
      bind(2, "terms", (frame.panel && panels.get(frame.panel)) || none);
      bind(3, "magma", magma);
      gl.uniform2i(at("cells"), ...(frame.panel?.layout.cells ?? ([1, 1] as [number, number])));
      gl.uniform2i(at("tile"), frame.panel?.columns ?? 1, frame.panel?.rows ?? 1);
      gl.uniform1i(at("term_count"), frame.panel?.most ?? 0);
      gl.uniform1i(at("derives_white"), frame.panel?.layout.derivesWhite ? 1 : 0);
      gl.uniform1i(at("samples"), samplesOf(frame.zoom));
      gl.uniform1i(at("canvas_height"), canvas.height);
      gl.uniform1f(at("zoom"), frame.zoom);
      gl.uniform1f(at("exposure"), frame.exposure);
      gl.uniform1f(at("gamma"), frame.gamma);
      gl.uniform1f(at("error_most"), frame.errorMost);
      gl.uniform3f(at("background"), ...frame.background);
      for (const pane of frame.panes) drawPane(frame, pane);
    },
  };
}
