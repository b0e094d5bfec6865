/* SPDX-License-Identifier: MIT
 *
 * spy_calls.h - what each GL function does to state that is not the runtime's own. Included by
 * spy.c, which defines the macros. A row is
 *
 *     SPY_VOID(name, parameters, arguments, what happens before the call)
 *
 * where "before" is one or more of
 *
 *     NOTHING           draws, queries or makes something new
 *     INTEGER(name)     sets what glGetIntegerv(name) tells (up to four values)
 *     CAPABILITY(name)  sets what glIsEnabled(name) tells
 *     FRAMEBUFFER(target) and TEXTURE(target) set the binding of a target, of textures on the
 *                       active unit
 *     SAMPLER(unit)     sets the sampler of a unit
 *     BOUND(kind, name) changes the object that glGetIntegerv(name) tells, which must be our own
 *     OWN(kind, object) changes this object, which must be our own
 *     OFF(capability)   works only while this capability of GL is disabled
 */
SPY_VOID(ActiveTexture, (GLenum unit), (unit), INTEGER(GL_ACTIVE_TEXTURE))
SPY_VOID(AttachShader, (GLuint program, GLuint shader), (program, shader),
         OWN(PROGRAM, program) OWN(SHADER, shader))
SPY_VOID(BindBuffer, (GLenum target, GLuint buffer), (target, buffer),
         INTEGER(buffer_binding(target)))
SPY_VOID(BindFramebuffer, (GLenum target, GLuint framebuffer), (target, framebuffer),
         FRAMEBUFFER(target))
SPY_VOID(BindSampler, (GLuint unit, GLuint sampler), (unit, sampler), SAMPLER(unit))
SPY_VOID(BindTexture, (GLenum target, GLuint texture), (target, texture), TEXTURE(target))
SPY_VOID(BindVertexArray, (GLuint array), (array), INTEGER(GL_VERTEX_ARRAY_BINDING))
SPY_VOID(BlendEquationSeparate, (GLenum rgb, GLenum alpha), (rgb, alpha),
         INTEGER(GL_BLEND_EQUATION_RGB) INTEGER(GL_BLEND_EQUATION_ALPHA))
SPY_VOID(BlendFuncSeparate, (GLenum src_rgb, GLenum dst_rgb, GLenum src_a, GLenum dst_a),
         (src_rgb, dst_rgb, src_a, dst_a),
         INTEGER(GL_BLEND_SRC_RGB) INTEGER(GL_BLEND_DST_RGB) INTEGER(GL_BLEND_SRC_ALPHA)
             INTEGER(GL_BLEND_DST_ALPHA))
SPY_VOID(ClearBufferfv, (GLenum buffer, GLint index, const GLfloat *value), (buffer, index, value),
         BOUND(FRAMEBUFFER, GL_DRAW_FRAMEBUFFER_BINDING))
SPY_VOID(ColorMask, (GLboolean r, GLboolean g, GLboolean b, GLboolean a), (r, g, b, a),
         INTEGER(GL_COLOR_WRITEMASK))
SPY_VOID(CompileShader, (GLuint shader), (shader), OWN(SHADER, shader))
SPY_VOID(CullFace, (GLenum mode), (mode), INTEGER(GL_CULL_FACE_MODE))
SPY_VOID(DepthFunc, (GLenum func), (func), INTEGER(GL_DEPTH_FUNC))
SPY_VOID(DepthMask, (GLboolean flag), (flag), INTEGER(GL_DEPTH_WRITEMASK))
SPY_VOID(Disable, (GLenum capability), (capability), CAPABILITY(capability))
SPY_VOID(DrawArrays, (GLenum mode, GLint first, GLsizei count), (mode, first, count),
         BOUND(PROGRAM, GL_CURRENT_PROGRAM) BOUND(VERTEX_ARRAY, GL_VERTEX_ARRAY_BINDING)
             OFF(GL_PRIMITIVE_RESTART))
SPY_VOID(DrawArraysInstanced, (GLenum mode, GLint first, GLsizei count, GLsizei instances),
         (mode, first, count, instances),
         BOUND(PROGRAM, GL_CURRENT_PROGRAM) BOUND(VERTEX_ARRAY, GL_VERTEX_ARRAY_BINDING)
             OFF(GL_PRIMITIVE_RESTART))
SPY_VOID(DrawBuffers, (GLsizei count, const GLenum *buffers), (count, buffers),
         BOUND(FRAMEBUFFER, GL_DRAW_FRAMEBUFFER_BINDING))
SPY_VOID(Enable, (GLenum capability), (capability), CAPABILITY(capability))
SPY_VOID(EnableVertexAttribArray, (GLuint index), (index),
         BOUND(VERTEX_ARRAY, GL_VERTEX_ARRAY_BINDING))
SPY_VOID(FramebufferTexture2D,
         (GLenum target, GLenum attachment, GLenum texture_target, GLuint texture, GLint level),
         (target, attachment, texture_target, texture, level),
         BOUND(FRAMEBUFFER, GL_DRAW_FRAMEBUFFER_BINDING) OWN(TEXTURE, texture))
SPY_VOID(FrontFace, (GLenum mode), (mode), INTEGER(GL_FRONT_FACE))
SPY_VOID(GetBooleanv, (GLenum name, GLboolean *values), (name, values), NOTHING)
SPY_VOID(GetFloatv, (GLenum name, GLfloat *values), (name, values), NOTHING)
SPY_VOID(GetIntegerv, (GLenum name, GLint *values), (name, values), NOTHING)
SPY_VOID(GenerateMipmap, (GLenum target), (target), BOUND(TEXTURE, texture_binding(target)))
SPY_VOID(GetProgramInfoLog, (GLuint program, GLsizei size, GLsizei *length, GLchar *log),
         (program, size, length, log), NOTHING)
SPY_VOID(GetShaderInfoLog, (GLuint shader, GLsizei size, GLsizei *length, GLchar *log),
         (shader, size, length, log), NOTHING)
SPY_VOID(InvalidateFramebuffer, (GLenum target, GLsizei count, const GLenum *attachments),
         (target, count, attachments), BOUND(FRAMEBUFFER, GL_DRAW_FRAMEBUFFER_BINDING))
SPY_VOID(LinkProgram, (GLuint program), (program), OWN(PROGRAM, program))
SPY_VOID(PixelStorei, (GLenum name, GLint value), (name, value), INTEGER(name))
SPY_VOID(PolygonMode, (GLenum face, GLenum mode), (face, mode), INTEGER(SPY_GL_POLYGON_MODE))
SPY_VOID(ReadBuffer, (GLenum source), (source), BOUND(FRAMEBUFFER, GL_READ_FRAMEBUFFER_BINDING))
SPY_VOID(SamplerParameteri, (GLuint sampler, GLenum name, GLint value), (sampler, name, value),
         OWN(SAMPLER, sampler))
SPY_VOID(Scissor, (GLint x, GLint y, GLsizei width, GLsizei height), (x, y, width, height),
         INTEGER(GL_SCISSOR_BOX))
SPY_VOID(ShaderSource,
         (GLuint shader, GLsizei count, const GLchar *const *strings, const GLint *lengths),
         (shader, count, strings, lengths), OWN(SHADER, shader))
SPY_VOID(TexParameteri, (GLenum target, GLenum name, GLint value), (target, name, value),
         BOUND(TEXTURE, texture_binding(target)))
SPY_VOID(Uniform1i, (GLint location, GLint x), (location, x), BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(Uniform1f, (GLint location, GLfloat x), (location, x), BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(Uniform4fv, (GLint location, GLsizei count, const GLfloat *values),
         (location, count, values), BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(Uniform2f, (GLint location, GLfloat x, GLfloat y), (location, x, y),
         BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(Uniform2i, (GLint location, GLint x, GLint y), (location, x, y),
         BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(Uniform3fv, (GLint location, GLsizei count, const GLfloat *values),
         (location, count, values), BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(UniformMatrix3fv,
         (GLint location, GLsizei count, GLboolean transpose, const GLfloat *values),
         (location, count, transpose, values), BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(UniformMatrix4fv,
         (GLint location, GLsizei count, GLboolean transpose, const GLfloat *values),
         (location, count, transpose, values), BOUND(PROGRAM, GL_CURRENT_PROGRAM))
SPY_VOID(UseProgram, (GLuint program), (program), INTEGER(GL_CURRENT_PROGRAM))
SPY_VOID(VertexAttribDivisor, (GLuint index, GLuint divisor), (index, divisor),
         BOUND(VERTEX_ARRAY, GL_VERTEX_ARRAY_BINDING))
SPY_VOID(VertexAttribIPointer,
         (GLuint index, GLint size, GLenum type, GLsizei stride, const void *offset),
         (index, size, type, stride, offset),
         BOUND(VERTEX_ARRAY, GL_VERTEX_ARRAY_BINDING) BOUND(BUFFER, GL_ARRAY_BUFFER_BINDING))
SPY_VOID(VertexAttribPointer,
         (GLuint index, GLint size, GLenum type, GLboolean normalized, GLsizei stride,
          const void *offset),
         (index, size, type, normalized, stride, offset),
         BOUND(VERTEX_ARRAY, GL_VERTEX_ARRAY_BINDING) BOUND(BUFFER, GL_ARRAY_BUFFER_BINDING))
SPY_VOID(Viewport, (GLint x, GLint y, GLsizei width, GLsizei height), (x, y, width, height),
         INTEGER(GL_VIEWPORT))

/* Queries: SPY_VALUE(type, what a lost context returns, name, parameters, arguments) */
SPY_VALUE(const GLubyte *, NULL, GetString, (GLenum name), (name))
SPY_VALUE(const GLubyte *, NULL, GetStringi, (GLenum name, GLuint index), (name, index))
SPY_VALUE(GLint, -1, GetUniformLocation, (GLuint program, const GLchar *name), (program, name))
SPY_VALUE(GLboolean, GL_FALSE, IsEnabled, (GLenum capability), (capability))

/* Arrays of names: SPY_GEN(kind, name, parameters), SPY_DELETE(kind, name, parameters) */
SPY_GEN(BUFFER, GenBuffers)
SPY_GEN(FRAMEBUFFER, GenFramebuffers)
SPY_GEN(SAMPLER, GenSamplers)
SPY_GEN(TEXTURE, GenTextures)
SPY_GEN(VERTEX_ARRAY, GenVertexArrays)
SPY_DELETE(BUFFER, DeleteBuffers)
SPY_DELETE(FRAMEBUFFER, DeleteFramebuffers)
SPY_DELETE(SAMPLER, DeleteSamplers)
SPY_DELETE(TEXTURE, DeleteTextures)
SPY_DELETE(VERTEX_ARRAY, DeleteVertexArrays)

/* Functions with a fault or a life of their own, which are written out in spy.c. */
SPY_OTHER(void, BufferData, (GLenum target, GLsizeiptr size, const void *data, GLenum usage))
SPY_OTHER(GLenum, CheckFramebufferStatus, (GLenum target))
SPY_OTHER(GLuint, CreateProgram, (void))
SPY_OTHER(GLuint, CreateShader, (GLenum type))
SPY_OTHER(void, DeleteProgram, (GLuint program))
SPY_OTHER(void, DeleteShader, (GLuint shader))
SPY_OTHER(GLenum, GetError, (void))
SPY_OTHER(GLenum, GetGraphicsResetStatus, (void))
SPY_OTHER(void, GetProgramiv, (GLuint program, GLenum name, GLint *value))
SPY_OTHER(void, GetShaderiv, (GLuint shader, GLenum name, GLint *value))
SPY_OTHER(void, TexImage2D,
          (GLenum target, GLint level, GLint internal_format, GLsizei width, GLsizei height,
           GLint border, GLenum format, GLenum type, const void *pixels))
SPY_OTHER(void, TexSubImage2D,
          (GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height,
           GLenum format, GLenum type, const void *pixels))
