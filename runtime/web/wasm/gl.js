// SPDX-License-Identifier: MIT
//
// gl.js - the GL functions that the runtime calls, on a WebGL 2 context of its own. Objects are
// numbers in C, so that a table has them. State that the runtime asks for is answered from what it
// has set, since a query of WebGL may wait for all that was drawn.

const VERSION = 0x1f02, RENDERER = 0x1f01, EXTENSIONS = 0x1f03;

/** The extensions that the runtime may use. */
const USED = ['EXT_color_buffer_float', 'EXT_color_buffer_half_float', 'EXT_float_blend', 'EXT_texture_filter_anisotropic'];
const CONTEXT_LOST = 0x9242, UNKNOWN_CONTEXT_RESET = 0x8255;

/** What GL's state is at the beginning, by name, where it is not 0. */
const STARTING = [
    [0x0b45, 0x0405], [0x0b46, 0x0901], [0x0b72, 1], [0x0b74, 0x0201], [0x0bd0, 1], [0x0cf5, 4], [0x84e0, 0x84c0],
    [0x80c8, 0], [0x80c9, 1], [0x80ca, 0], [0x80cb, 1], [0x8009, 0x8006], [0x883d, 0x8006],
    [0x821b, 3], [0x821c, 0], [0x0b70, [0, 1]],
];
const ACTIVE_TEXTURE = 0x84e0, TEXTURE_2D = 0x0de1, TEXTURE_BINDING_2D = 0x8069, TEXTURE_BINDING_CUBE_MAP = 0x8514, SAMPLER_BINDING = 0x8919;
const BINDINGS = new Map([[0x88ec, 0x88ef], [0x8892, 0x8894], [0x8a11, 0x8a28]]); // buffers: unpack, array, uniform

/** @param gl a context that nothing else draws with
 *  @param memory () => the module's WebAssembly.Memory
 *  @param allocate (size) => memory of the module */
export function makeGl(gl, memory, allocate) {
    const decoder = new TextDecoder(), objects = [null], free = [], state = new Map(STARTING), units = [], texts = new Map();
    let views = { buffer: null };
    const view = () => {
        const { buffer } = memory();
        if (views.buffer !== buffer) {
            views = { buffer, u8: new Uint8Array(buffer), i32: new Int32Array(buffer), u32: new Uint32Array(buffer), f32: new Float32Array(buffer) };
        }
        return views;
    };

    // ---- texts -------------------------------------------------------------------------------
    const read = (at, length) => {
        const { u8 } = view(), end = length >= 0 ? at + length : u8.indexOf(0, at);
        return decoder.decode(u8.subarray(at, end));
    };
    const write = (text, at, room) => {
        if (room <= 0) return 0;
        const bytes = new TextEncoder().encode(text).subarray(0, room - 1), { u8 } = view();
        u8.set(bytes, at);
        u8[at + bytes.length] = 0;
        return bytes.length;
    };
    const keep = (text) => {
        if (!texts.has(text)) {
            const room = 3 * text.length + 1, at = allocate(room);
            if (!at) return 0;
            write(text, at, room);
            texts.set(text, at);
        }
        return texts.get(text);
    };

    // ---- objects -----------------------------------------------------------------------------
    const add = (object) => {
        const name = free.pop() ?? objects.length;
        objects[name] = object;
        return name;
    };
    const make = (create) => (count, names) => {
        for (let i = 0; i < count; ++i) {
            const name = add(gl[create]());
            view().u32[(names >> 2) + i] = name;
        }
    };
    const locations = new Map(); // of uniforms, by program
    const forget = (name) => {
        objects[name] = null;
        free.push(name);
    };
    const drop = (name, remove) => {
        if (!name || !objects[name]) return;
        gl[remove](objects[name]);
        forget(name);
    };
    /** Names that are deleted are bound no more. */
    const remove = (method, ...bindings) => (count, names) => {
        for (let i = 0; i < count; ++i) {
            const name = view().u32[(names >> 2) + i];
            drop(name, method);
            for (const binding of bindings) if (state.get(binding) === name) state.set(binding, 0);
            for (const unit of units) for (const key of Object.keys(unit ?? {})) if (bindings.includes(+key) && unit[key] === name) unit[key] = 0;
        }
    };
    const unitOf = (index) => (units[index] ??= {});
    const active = () => unitOf(state.get(ACTIVE_TEXTURE) - 0x84c0);
    const pixels = (type, at) => (at ? (type === 0x1406 ? [view().f32, at >> 2] : [view().u8, at]) : [null]);
    const matrix = (method, size) => (location, count, transpose, values) => gl[method](objects[location] ?? null, !!transpose, view().f32, values >> 2, size * count);
    const vector = (method, size) => (location, count, values) => gl[method](objects[location] ?? null, view().f32, values >> 2, size * count);
    const scalar = (method) => (location, ...values) => gl[method](objects[location] ?? null, ...values);
    const info = (method) => (object, room, length, at) => {
        const count = write(gl[method](objects[object]) ?? '', at, room);
        if (length) view().i32[length >> 2] = count;
    };

    // ---- queries -----------------------------------------------------------------------------
    const extensions = USED.filter((name) => gl.getExtension(name)).map((name) => `GL_${name}`);
    extensions.push('GL_EXT_robustness'); // of which GetGraphicsResetStatusEXT is
    const asked = new Set([0x0d33, 0x84ff]); // limits, which WebGL knows
    const lookUp = (name) => {
        if (name === 0x821d) return extensions.length;
        if (name === TEXTURE_BINDING_2D || name === TEXTURE_BINDING_CUBE_MAP || name === SAMPLER_BINDING) return active()[name] ?? 0;
        return asked.has(name) ? gl.getParameter(name) ?? 0 : state.get(name) ?? 0;
    };
    const setViewport = (...rect) => state.set(0x0ba2, rect);
    setViewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    state.set(0x0c10, state.get(0x0ba2));
    const colorMask = [1, 1, 1, 1];

    const functions = {
        ActiveTexture(unit) {
            state.set(ACTIVE_TEXTURE, unit);
            gl.activeTexture(unit);
        },
        AttachShader: (program, shader) => gl.attachShader(objects[program], objects[shader]),
        BindBuffer(target, buffer) {
            state.set(BINDINGS.get(target), buffer);
            gl.bindBuffer(target, objects[buffer]);
        },
        BindFramebuffer(target, framebuffer) {
            if (target !== 0x8ca8) state.set(0x8ca6, framebuffer);
            if (target !== 0x8ca9) state.set(0x8caa, framebuffer);
            gl.bindFramebuffer(target, objects[framebuffer]);
        },
        BindSampler(unit, sampler) {
            unitOf(unit)[SAMPLER_BINDING] = sampler;
            gl.bindSampler(unit, objects[sampler]);
        },
        BindTexture(target, texture) {
            active()[target === TEXTURE_2D ? TEXTURE_BINDING_2D : TEXTURE_BINDING_CUBE_MAP] = texture;
            gl.bindTexture(target, objects[texture]);
        },
        BindVertexArray(array) {
            state.set(0x85b5, array);
            gl.bindVertexArray(objects[array]);
        },
        BufferData: (target, size, data, usage) => (data ? gl.bufferData(target, view().u8, usage, data, size) : gl.bufferData(target, size, usage)),
        BlendEquationSeparate(rgb, alpha) {
            state.set(0x8009, rgb).set(0x883d, alpha);
            gl.blendEquationSeparate(rgb, alpha);
        },
        BlendFuncSeparate(source, destination, sourceAlpha, destinationAlpha) {
            state.set(0x80c9, source).set(0x80c8, destination).set(0x80cb, sourceAlpha).set(0x80ca, destinationAlpha);
            gl.blendFuncSeparate(source, destination, sourceAlpha, destinationAlpha);
        },
        CheckFramebufferStatus: (target) => gl.checkFramebufferStatus(target),
        ClearBufferfv: (buffer, index, value) => gl.clearBufferfv(buffer, index, view().f32, value >> 2),
        ColorMask(...mask) {
            colorMask.splice(0, 4, ...mask);
            gl.colorMask(...mask.map((on) => !!on));
        },
        CompileShader: (shader) => gl.compileShader(objects[shader]),
        CreateProgram: () => add(gl.createProgram()),
        CreateShader: (type) => add(gl.createShader(type)),
        CullFace(mode) {
            state.set(0x0b45, mode);
            gl.cullFace(mode);
        },
        DeleteBuffers: remove('deleteBuffer', ...BINDINGS.values()),
        DeleteFramebuffers: remove('deleteFramebuffer', 0x8ca6, 0x8caa),
        DeleteProgram(program) {
            for (const at of locations.get(program) ?? []) forget(at);
            locations.delete(program);
            drop(program, 'deleteProgram');
        },
        DeleteSamplers: remove('deleteSampler', SAMPLER_BINDING),
        DeleteShader: (shader) => drop(shader, 'deleteShader'),
        DeleteTextures: remove('deleteTexture', TEXTURE_BINDING_2D, TEXTURE_BINDING_CUBE_MAP),
        DeleteVertexArrays: remove('deleteVertexArray', 0x85b5),
        DepthFunc(func) {
            state.set(0x0b74, func);
            gl.depthFunc(func);
        },
        DepthMask(flag) {
            state.set(0x0b72, flag);
            gl.depthMask(!!flag);
        },
        Disable(capability) {
            state.set(capability, 0);
            gl.disable(capability);
        },
        DrawArrays: (mode, first, count) => gl.drawArrays(mode, first, count),
        DrawArraysInstanced: (mode, first, count, instances) => gl.drawArraysInstanced(mode, first, count, instances),
        DrawBuffers: (count, buffers) => gl.drawBuffers(view().u32.slice(buffers >> 2, (buffers >> 2) + count)),
        Enable(capability) {
            state.set(capability, 1);
            gl.enable(capability);
        },
        EnableVertexAttribArray: (index) => gl.enableVertexAttribArray(index),
        FramebufferTexture2D: (target, attachment, kind, texture, level) => gl.framebufferTexture2D(target, attachment, kind, objects[texture], level),
        FrontFace(mode) {
            state.set(0x0b46, mode);
            gl.frontFace(mode);
        },
        GenBuffers: make('createBuffer'),
        GenFramebuffers: make('createFramebuffer'),
        GenSamplers: make('createSampler'),
        GenTextures: make('createTexture'),
        GenVertexArrays: make('createVertexArray'),
        GenerateMipmap: (target) => gl.generateMipmap(target),
        GetBooleanv(name, values) {
            if (name === 0x0c23) view().u8.set(colorMask, values);
            else view().u8[values] = lookUp(name);
        },
        GetFloatv: (name, values) => view().f32.set([lookUp(name)].flat(), values >> 2),
        GetError: () => (gl.isContextLost() ? CONTEXT_LOST : gl.getError()),
        GetGraphicsResetStatusEXT: () => (gl.isContextLost() ? UNKNOWN_CONTEXT_RESET : 0),
        GetIntegerv: (name, values) => view().i32.set([lookUp(name)].flat(), values >> 2),
        GetProgramInfoLog: info('getProgramInfoLog'),
        GetProgramiv: (program, name, value) => { view().i32[value >> 2] = +gl.getProgramParameter(objects[program], name); },
        GetShaderInfoLog: info('getShaderInfoLog'),
        GetShaderiv: (shader, name, value) => { view().i32[value >> 2] = +gl.getShaderParameter(objects[shader], name); },
        GetString: (name) => keep(name === VERSION ? 'OpenGL ES 3.0 (WebGL 2)' : name === RENDERER ? 'WebGL' : ''),
        GetStringi: (name, index) => (name === EXTENSIONS ? keep(extensions[index]) : 0),
        GetUniformLocation(program, name) {
            const location = gl.getUniformLocation(objects[program], read(name));
            if (!location) return -1;
            const at = add(location);
            locations.set(program, [...locations.get(program) ?? [], at]);
            return at;
        },
        IsEnabled: (capability) => state.get(capability) ?? 0,
        LinkProgram: (program) => gl.linkProgram(objects[program]),
        PixelStorei(name, value) {
            state.set(name, value);
            gl.pixelStorei(name, value);
        },
        ReadBuffer: (source) => gl.readBuffer(source),
        SamplerParameteri: (sampler, name, value) => gl.samplerParameteri(objects[sampler], name, value),
        Scissor(...rect) {
            state.set(0x0c10, rect);
            gl.scissor(...rect);
        },
        ShaderSource(shader, count, strings, lengths) {
            const { u32, i32 } = view();
            let text = '';
            for (let i = 0; i < count; ++i) text += read(u32[(strings >> 2) + i], lengths ? i32[(lengths >> 2) + i] : -1);
            gl.shaderSource(objects[shader], text);
        },
        TexImage2D: (target, level, internal, width, height, border, format, type, at) => gl.texImage2D(target, level, internal, width, height, border, format, type, ...pixels(type, at)),
        TexParameteri: (target, name, value) => gl.texParameteri(target, name, value),
        TexSubImage2D: (target, level, x, y, width, height, format, type, at) => gl.texSubImage2D(target, level, x, y, width, height, format, type, ...pixels(type, at)),
        Uniform1f: scalar('uniform1f'),
        Uniform1i: scalar('uniform1i'),
        Uniform2f: scalar('uniform2f'),
        Uniform2i: scalar('uniform2i'),
        Uniform3fv: vector('uniform3fv', 3),
        Uniform4fv: vector('uniform4fv', 4),
        UniformMatrix3fv: matrix('uniformMatrix3fv', 9),
        UniformMatrix4fv: matrix('uniformMatrix4fv', 16),
        UseProgram(program) {
            state.set(0x8b8d, program);
            gl.useProgram(objects[program]);
        },
        VertexAttribDivisor: (index, divisor) => gl.vertexAttribDivisor(index, divisor),
        VertexAttribIPointer: (index, size, type, stride, offset) => gl.vertexAttribIPointer(index, size, type, stride, offset),
        VertexAttribPointer: (index, size, type, normalized, stride, offset) => gl.vertexAttribPointer(index, size, type, !!normalized, stride, offset),
        Viewport(...rect) {
            setViewport(...rect);
            gl.viewport(...rect);
        },
    };

    /** Makes a texture with mipmaps of a decoded image. @returns its name. */
    const makeTexture = (bitmap, isSrgb) => {
        const texture = gl.createTexture();
        gl.bindTexture(TEXTURE_2D, texture);
        gl.texImage2D(TEXTURE_2D, 0, isSrgb ? gl.SRGB8_ALPHA8 : gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
        gl.generateMipmap(TEXTURE_2D);
        gl.bindTexture(TEXTURE_2D, objects[active()[TEXTURE_BINDING_2D] ?? 0]);
        return add(texture);
    };
    const imports = Object.fromEntries(Object.entries(functions).map(([name, f]) => [`gl${name}`, f]));
    return { imports, makeTexture, dropTexture: (name) => drop(name, 'deleteTexture'), read, view };
}
