/* Implementation by filter-tuner; do not edit it, export it again. */
#include "local_level.h"

#include <math.h>
#include <stdbool.h>

#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "NaN is a missing sample: compile without -ffast-math and -ffinite-math-only."
#endif

void local_level_init(local_level_state *state)
{
    state->level = 0.0f;
    state->p = 0.0f;
    state->known = 0.0f;
    state->outside[0] = 0.0f;
}

void local_level_step(local_level_state *state,
    const local_level_input *in, local_level_output *out)
{
    /* gated.py:97: gated = jnp.array([bool(part) for part in self.parts]) & (state.outside < self.patience) */
    const bool gated_0 = state->outside[0] < 10.0f;

    /* local_level.py:118: known = state.known > 0 */
    const bool known = state->known > 0.0f;
    const bool t0 = isnan(in->z);

    /* local_level.py:120: seen = ~jnp.isnan(inputs.z) & (sigma > 0) */
    const bool seen = !t0;

    /* local_level.py:122: p = state.p + params.q * self.dt / params.R */
    const float p = state->p + 0.96809506f;
    const float t1 = p + 1.0f;
    const float t2 = p / t1;

    /* local_level.py:123: K = jnp.where(known, p / (p + r), 1.0) */
    const float K = known ? t2 : 1.0f;
    const float t3 = in->z - state->level;

    /* local_level.py:124: y = jnp.where(seen, inputs.z - state.level, 0.0) */
    const float y = t0 ? 0.0f : t3;

    /* local_level.py:125: level = state.level + K * y */
    const float level = state->level + (K * y);

    /* local_level.py:126: counts = seen & known */
    const bool counts = seen && known;
    const float t4 = 1e-06f * t1;

    /* local_level.py:127: variance = jnp.where(counts, params.R * (p + r), 0.0) */
    const float variance = counts ? t4 : 0.0f;
    const float t5 = t0 ? p : K;
    const float t6 = seen ? 1.0f : 0.0f;
    const float t7 = ((state->known > t6) || isnan(state->known)) ? state->known : t6;
    const float t8 = counts ? y : 0.0f;

    /* gated.py:112: wrong = gated & ~seen.rejected & self._beyond(*_judged(seen.stepped)) */
    const bool wrong_0 = gated_0 && ((variance > 0.0f) && ((t8 * t8) > (9.0f * variance)));

    /* gated.py:118: fresh = one & ~seen.rejected & (now_s != 0) */
    const bool fresh_0 = wrong_0 && (variance != 0.0f);
    const float t9 = fresh_0 ? ((float)NAN) : in->z;
    const bool t10 = isnan(t9);

    /* local_level.py:120: seen = ~jnp.isnan(inputs.z) & (sigma > 0) */
    const bool seen_b = !t10;
    const float t11 = t9 - state->level;

    /* local_level.py:124: y = jnp.where(seen, inputs.z - state.level, 0.0) */
    const float y_b = t10 ? 0.0f : t11;

    /* local_level.py:125: level = state.level + K * y */
    const float level_b = state->level + (K * y_b);

    /* local_level.py:126: counts = seen & known */
    const bool counts_b = seen_b && known;

    /* local_level.py:127: variance = jnp.where(counts, params.R * (p + r), 0.0) */
    const float variance_b = counts_b ? t4 : 0.0f;
    const float t12 = t10 ? p : K;
    const float t13 = seen_b ? 1.0f : 0.0f;
    const float t14 = ((state->known > t13) || isnan(state->known)) ? state->known : t13;
    const float t15 = counts_b ? y_b : 0.0f;
    const float t16 = fresh_0 ? t8 : 0.0f;
    const float t17 = fresh_0 ? variance : 0.0f;
    const float t18 = wrong_0 ? level_b : level;
    const float t19 = wrong_0 ? t12 : t5;
    const float t20 = wrong_0 ? t14 : t7;
    const float t21 = wrong_0 ? t15 : t8;
    const float t22 = wrong_0 ? variance_b : variance;
    const bool t23 = wrong_0 && fresh_0;
    const float t24 = wrong_0 ? t16 : 0.0f;
    const float t25 = wrong_0 ? t17 : 0.0f;

    /* gated.py:134: offered = jnp.where(rejected, seen.offered, output.innovation) */
    const float offered_0 = t23 ? t24 : t21;

    /* gated.py:135: predicted = jnp.where(rejected, seen.predicted, output.variance) */
    const float predicted_0 = t23 ? t25 : t22;

    /* gated.py:136: outside = self._beyond(offered, predicted) */
    const bool outside_0 = (predicted_0 > 0.0f) && ((offered_0 * offered_0) > (9.0f * predicted_0));
    const float t26 = state->outside[0] + 1.0f;

    /* gated.py:137: again_outside = jnp.where(outside, state.outside + 1, 0) */
    const float again_outside_0 = outside_0 ? t26 : 0.0f;

    /* gated.py:138: counted = jnp.where(predicted != 0, again_outside, state.outside) */
    const float counted_0 = (predicted_0 != 0.0f) ? again_outside_0 : state->outside[0];

    state->level = t18;
    state->p = t19;
    state->known = t20;
    state->outside[0] = counted_0;
    out->level = t18;
}
