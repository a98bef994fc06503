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

static int local_level_off(const double found, const double right, const double allowed)
{
    int off = 1;
    if (fabs(found - right) <= allowed) {
        off = 0;
    }
    if ((isnan(right) != 0) && (isnan(found) != 0)) {
        off = 0;
    }
    return off;
}

static int local_level_run_selftest(void)
{
    static const double samples[50][1] = {
        {0.345584192064786},
        {1.1672023355659444},
        {1.4976394117493315},
        {0.19448218014497054},
        {(double)NAN},
        {1.5462126191820995},
        {1.0092593838218145},
        {1.5903774880181676},
        {1.9549498842042432},
        {2.249082380859769},
        {2.2775046221755657},
        {2.824217608788013},
        {2.087763521786346},
        {1.9248535737932932},
        {1.442734261113315},
        {2.0415804737479424},
        {2.0813025812296013},
        {(double)NAN},
        {1.0069373679076707},
        {0.7497451272888},
        {0.7578873078071435},
        {0.4822844025077731},
        {1.7763482169059803},
        {2.783072532211775},
        {0.07191005324580635},
        {-1.8171031927218664},
        {1.4836438217825374},
        {-3.2888188974835595},
        {-2.931944941298185},
        {-4.136504727590074},
        {(double)NAN},
        {-4.967910083910004},
        {-5.3876435814960075},
        {-6.303140730402067},
        {-7.166402773961891},
        {-11.865466276814079},
        {-11.364730579377321},
        {-15.796267764802861},
        {-12.557518378524696},
        {-9.717767164992289},
        {-14.383879871439495},
        {-11.671309424436787},
        {-16.111523213143304},
        {(double)NAN},
        {-23.466210575085476},
        {-25.510754726296874},
        {-28.873012273388284},
        {-30.494595490933246},
        {-32.02313856252823},
        {-30.83110612806061}
    };
    static const double expected[50][1] = {
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {0.345584192064786},
        {1.959823348046515},
        {1.9369343695049033},
        {1.6311710204933754},
        {1.8829251158402658},
        {2.0044572693252567},
        {2.0044572693252567},
        {1.2880222464076092},
        {0.9501229151058829},
        {0.8319426431766159},
        {0.6176606318865632},
        {1.3274059415582915},
        {2.2190000488719748},
        {0.9039239556143136},
        {-0.7626815511986194},
        {0.6131729076503772},
        {-1.7767625370640912},
        {-2.4843015314714423},
        {-3.496261359373905},
        {-3.496261359373905},
        {-4.553207092793039},
        {-5.077016913237403},
        {-5.830798142418967},
        {-6.649300318196616},
        {-9.844423266294596},
        {-10.775609740345669},
        {-13.850724128931228},
        {-13.058646833294398},
        {-11.012387532046509},
        {-13.077396749362602},
        {-12.216180712587484},
        {-14.60204350219107},
        {-14.60204350219107},
        {-20.968334188144972},
        {-23.81979684430299},
        {-26.926350101104806},
        {-29.113087512990816},
        {-30.895617241201002},
        {-30.856104258881327}
    };
    static const double allowed[50][1] = {
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089561790733482e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.089562434662836e-08},
        {3.08956261229852e-08},
        {3.08956261229852e-08},
        {3.08956261229852e-08},
        {3.08956261229852e-08},
        {3.089562789934204e-08},
        {3.089562789934204e-08},
        {3.089562789934204e-08},
        {3.089563145205572e-08},
        {3.089563855748308e-08},
        {3.089565276833779e-08},
        {3.089565276833779e-08},
        {3.089565276833779e-08},
        {3.089565276833779e-08},
        {3.089565987376515e-08},
        {3.089565987376515e-08},
        {3.089565987376515e-08},
        {3.0895674084619865e-08},
        {3.0895702506329295e-08},
        {3.0895702506329295e-08},
        {3.0895702506329295e-08},
        {3.0895702506329295e-08},
        {3.0895702506329295e-08}
    };
    static const double start[4] = {
        0.0, 0.0, 0.0, 0.0
    };
    static const double allowed_start[4] = {
        0.0, 0.0, 0.0, 0.0
    };
    static const double after[4] = {
        -30.856104258881327, 0.6124988454886188, 1.0, 45.0
    };
    static const double allowed_after[4] = {
        3.090118952400962e-08, 6.574988454886189e-10, 1.045e-09, 4.5045000000000004e-08
    };
    local_level_state state;
    local_level_input input;
    local_level_output output;
    int off = 0;
    int first = 1;
    local_level_init(&state);
    off |= local_level_off(state.level, start[0], allowed_start[0]);
    off |= local_level_off(state.p, start[1], allowed_start[1]);
    off |= local_level_off(state.known, start[2], allowed_start[2]);
    for (int i = 0; i < 1; i++) {
        off |= local_level_off(state.outside[i], start[3 + i], allowed_start[3 + i]);
    }
    for (int k = 0; (k < 50) && (off == 0); k++) {
        input.z = samples[k][0];
        local_level_step(&state, &input, &output);
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
    static const double given[2][4] = {
        {0.345584192064786, 0.0, 1.0, 10.0},
        {73.44274431587479, 0.6124911452379999, 0.0, 0.0}
    };
    static const double samples[2][1] = {
        {2.087763521786346},
        {-32.02313856252823}
    };
    static const double expected[2][1] = {
        {1.2025525497319878},
        {-32.02313856252823}
    };
    static const double allowed[2][1] = {
        {2.8444380626275636e-15},
        {2.8423764547594053e-13}
    };
    static const double after[2][4] = {
        {1.2025525497319878, 0.4918944583070934, 1.0, 11.0},
        {-32.02313856252823, 1.0, 1.0, 0.0}
    };
    static const double allowed_after[2][4] = {
        {2.8444380626275636e-15, 1.1030238574135373e-15, 8.881784197001252e-16,
            1.687538997430238e-14},
        {2.8423764547594053e-13, 8.881784197001252e-16, 8.881784197001252e-16, 0.0}
    };
    local_level_state state;
    local_level_input input;
    local_level_output output;
    int off = 0;
    int first = 0;
    for (int k = 0; (k < 2) && (off == 0); k++) {
        state.level = given[k][0];
        state.p = given[k][1];
        state.known = given[k][2];
        state.outside[0] = given[k][3];
        input.z = samples[k][0];
        local_level_step(&state, &input, &output);
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
