/*
 * Samples, and what filter-tuner's own filter makes of them; written by filter-tuner.
 * local_level_selftest() is 0, or the number of the first sample that is off. Alone:
 * cc -DSELFTEST_MAIN local_level.c local_level_selftest.c -lm && ./a.out
 */
#include "local_level.h"

#include <math.h>
#ifdef SELFTEST_MAIN
#include <stdio.h>
#endif

static int local_level_off(const float found, const float right, const float allowed)
{
    int off = 1;
    if (fabsf(found - right) <= allowed) {
        off = 0;
    }
    if ((isnan(right) != 0) && (isnan(found) != 0)) {
        off = 0;
    }
    return off;
}

static int local_level_run_selftest(void)
{
    static const float samples[50][1] = {
        {0.34558418f},
        {1.1672024f},
        {1.4976394f},
        {0.19448218f},
        {(float)NAN},
        {1.5462127f},
        {1.0092593f},
        {1.5903774f},
        {1.9549499f},
        {2.2490823f},
        {2.2775047f},
        {2.8242176f},
        {2.0877635f},
        {1.9248536f},
        {1.4427342f},
        {2.0415804f},
        {2.0813026f},
        {(float)NAN},
        {1.0069374f},
        {0.74974513f},
        {0.7578873f},
        {0.4822844f},
        {1.7763482f},
        {2.7830725f},
        {0.07191005f},
        {-1.8171031f},
        {1.4836438f},
        {-3.2888188f},
        {-2.9319448f},
        {-4.1365047f},
        {(float)NAN},
        {-4.9679103f},
        {-5.387644f},
        {-6.3031406f},
        {-7.166403f},
        {-11.865466f},
        {-11.364731f},
        {-15.7962675f},
        {-12.557518f},
        {-9.717767f},
        {-14.38388f},
        {-11.671309f},
        {-16.111523f},
        {(float)NAN},
        {-23.466211f},
        {-25.510756f},
        {-28.873013f},
        {-30.494595f},
        {-32.02314f},
        {-30.831106f}
    };
    static const float expected[50][1] = {
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {0.34558418f},
        {1.9598234f},
        {1.9369344f},
        {1.631171f},
        {1.882925f},
        {2.0044572f},
        {2.0044572f},
        {1.2880222f},
        {0.9501229f},
        {0.8319426f},
        {0.61766064f},
        {1.3274059f},
        {2.2189999f},
        {0.90392405f},
        {-0.7626814f},
        {0.613173f},
        {-1.7767624f},
        {-2.4843013f},
        {-3.4962611f},
        {-3.4962611f},
        {-4.553207f},
        {-5.077017f},
        {-5.830798f},
        {-6.6493f},
        {-9.844423f},
        {-10.77561f},
        {-13.850724f},
        {-13.058646f},
        {-11.012387f},
        {-13.077396f},
        {-12.216181f},
        {-14.602043f},
        {-14.602043f},
        {-20.968334f},
        {-23.819798f},
        {-26.92635f},
        {-29.113087f},
        {-30.895618f},
        {-30.856104f}
    };
    static const float allowed[50][1] = {
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.0001239401f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012692033f},
        {0.00012739717f},
        {0.00012739717f},
        {0.00012739717f},
        {0.00012739717f},
        {0.00012739717f},
        {0.00012835085f},
        {0.00012835085f},
        {0.00012835085f},
        {0.00012835085f},
        {0.00012930452f},
        {0.00012930452f},
        {0.00012930452f},
        {0.00013121187f},
        {0.00013121187f},
        {0.00014265596f},
        {0.00014265596f},
        {0.00014265596f},
        {0.00014265596f},
        {0.00014265596f},
        {0.00014265596f},
        {0.00014265596f},
        {0.00014647066f},
        {0.00015410005f},
        {0.00015410005f},
        {0.00016172945f},
        {0.00016172945f},
        {0.00016172945f}
    };
    static const float start[4] = {
        0.0f, 0.0f, 0.0f, 0.0f
    };
    static const float allowed_start[4] = {
        0.0f, 0.0f, 0.0f, 0.0f
    };
    static const float after[4] = {
        -30.856104f, 0.6124988f, 1.0f, 45.0f
    };
    static const float allowed_after[4] = {
        0.00020657139f, 4.7552636e-05f, 4.9e-05f, 0.000225f
    };
    local_level_state state;
    local_level_input input;
    local_level_output output;
    int off = 0;
    local_level_params params;
    local_level_tables tables;
    local_level_defaults(&params);
    local_level_set(&tables, &params);
    int first = 1;
    local_level_init(&state, &params);
    off |= local_level_off(state.level, start[0], allowed_start[0]);
    off |= local_level_off(state.p, start[1], allowed_start[1]);
    off |= local_level_off(state.known, start[2], allowed_start[2]);
    for (int i = 0; i < 1; i++) {
        off |= local_level_off(state.outside[i], start[3 + i], allowed_start[3 + i]);
    }
    for (int k = 0; (k < 50) && (off == 0); k++) {
        input.z = samples[k][0];
        local_level_step(&state, &input, &output, &tables);
        off |= local_level_off(output.level, expected[k][0], allowed[k][0]);
        first = k + 1;
    }
    off |= local_level_off(state.level, after[0], allowed_after[0]);
    off |= local_level_off(state.p, after[1], allowed_after[1]);
    off |= local_level_off(state.known, after[2], allowed_after[2]);
    for (int i = 0; i < 1; i++) {
        off |= local_level_off(state.outside[i], after[3 + i], allowed_after[3 + i]);
    }
    return (off != 0) ? first : 0;
}

/*
 * Single steps from given states.
 * Of 8 constants in its formulas 5 show in them:
 * changed by a thousandth, each of these moves a result further than is allowed.
 * The other 3 move none beyond rounding,
 * in 64 steps from states near and far; 3 have no effect there.
 */
static int local_level_step_selftest(void)
{
    static const float given[2][4] = {
        {0.34558418f, 0.0f, 1.0f, 10.0f},
        {73.44274f, 0.61249113f, 0.0f, 0.0f}
    };
    static const float samples[2][1] = {
        {2.0877635f},
        {-32.02314f}
    };
    static const float expected[2][1] = {
        {1.2025526f},
        {-32.02314f}
    };
    static const float allowed[2][1] = {
        {1.521433e-06f},
        {0.000101612124f}
    };
    static const float after[2][4] = {
        {1.2025526f, 0.49189445f, 1.0f, 11.0f},
        {-32.02314f, 1.0f, 1.0f, 0.0f}
    };
    static const float allowed_after[2][4] = {
        {1.521433e-06f, 5.987228e-07f, 4.7683716e-07f, 8.267053e-06f},
        {0.000101612124f, 4.7683716e-07f, 4.7683716e-07f, 0.0f}
    };
    local_level_state state;
    local_level_input input;
    local_level_output output;
    int off = 0;
    local_level_params params;
    local_level_tables tables;
    local_level_defaults(&params);
    local_level_set(&tables, &params);
    int first = 0;
    for (int k = 0; (k < 2) && (off == 0); k++) {
        state.level = given[k][0];
        state.p = given[k][1];
        state.known = given[k][2];
        state.outside[0] = given[k][3];
        input.z = samples[k][0];
        local_level_step(&state, &input, &output, &tables);
        off |= local_level_off(output.level, expected[k][0], allowed[k][0]);
        off |= local_level_off(state.level, after[k][0], allowed_after[k][0]);
        off |= local_level_off(state.p, after[k][1], allowed_after[k][1]);
        off |= local_level_off(state.known, after[k][2], allowed_after[k][2]);
        for (int i = 0; i < 1; i++) {
            off |= local_level_off(state.outside[i], after[k][3 + i], allowed_after[k][3 + i]);
        }
        first = 51 + k;
    }
    return (off != 0) ? first : 0;
}

int local_level_selftest(void)
{
    int off = local_level_run_selftest();
    if (off == 0) {
        off = local_level_step_selftest();
    }
    return off;
}

#ifdef SELFTEST_MAIN

int main(void)
{
    const int off = local_level_selftest();
    if (off == 0) {
        (void)puts("the filter does what it should");
    } else {
        (void)printf("sample %d is off\n", off);
    }
    return (off == 0) ? 0 : 1;
}
#endif
