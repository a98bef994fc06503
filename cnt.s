	.file	"n_tilt_x16.c"
	.text
	.section	.text.unlikely,"ax",@progbits
	.type	slow, @function
slow:
.LFB1:
	.cfi_startproc
	subq	$24, %rsp
	.cfi_def_cfa_offset 32
	leaq	8(%rsp), %rdi
	movq	%rsp, %rsi
	call	sincos@PLT
	vmovsd	8(%rsp), %xmm0
	vmovsd	(%rsp), %xmm1
	addq	$24, %rsp
	.cfi_def_cfa_offset 8
	ret
	.cfi_endproc
.LFE1:
	.size	slow, .-slow
.LCOLDB32:
	.text
.LHOTB32:
	.p2align 4
	.globl	run
	.type	run, @function
run:
.LFB3:
	.cfi_startproc
	leaq	8(%rsp), %r10
	.cfi_def_cfa 10, 0
	andq	$-64, %rsp
	pushq	-8(%r10)
	pushq	%rbp
	movq	%rsp, %rbp
	.cfi_escape 0x10,0x6,0x2,0x76,0
	pushq	%r15
	pushq	%r14
	pushq	%r13
	pushq	%r12
	pushq	%r10
	.cfi_escape 0xf,0x3,0x76,0x58,0x6
	.cfi_escape 0x10,0xf,0x2,0x76,0x78
	.cfi_escape 0x10,0xe,0x2,0x76,0x70
	.cfi_escape 0x10,0xd,0x2,0x76,0x68
	.cfi_escape 0x10,0xc,0x2,0x76,0x60
	pushq	%rbx
	leaq	-2304(%rbp), %rax
	subq	$9152, %rsp
	.cfi_escape 0x10,0x3,0x2,0x76,0x50
	vmovsd	24(%rdx), %xmm6
	vmovupd	64(%rcx), %zmm3
	movq	%r8, -2480(%rbp)
	vmovsd	8(%rdx), %xmm4
	movq	%r9, -2544(%rbp)
	movq	%rdi, -6864(%rbp)
	movq	%rsi, %rbx
	movq	%rax, %rdi
	xorl	%esi, %esi
	movl	$1, %r15d
	vmovsd	16(%rdx), %xmm2
	vmovupd	128(%rcx), %zmm5
	vmovupd	256(%rcx), %zmm0
	vmovsd	%xmm6, -2344(%rbp)
	vmovupd	192(%rcx), %zmm6
	vmovapd	%zmm3, -8624(%rbp)
	vmovupd	(%rcx), %zmm3
	vmovsd	%xmm4, -2848(%rbp)
	vmovsd	(%rdx), %xmm4
	vmovsd	%xmm2, -2856(%rbp)
	vmovapd	%zmm5, -8688(%rbp)
	vmovapd	%zmm6, -4464(%rbp)
	vmovsd	32(%rdx), %xmm6
	vmovapd	%zmm3, -4976(%rbp)
	vmovsd	%xmm4, -8712(%rbp)
	vmovsd	%xmm6, -8560(%rbp)
	vmovapd	%zmm0, -8944(%rbp)
	vmovsd	.LC1(%rip), %xmm1
	vmovupd	320(%rcx), %zmm7
	movq	%rax, -8728(%rbp)
	vmovsd	40(%rdx), %xmm0
	movl	$2256, %edx
	vmulsd	%xmm4, %xmm1, %xmm1
	vmovapd	%zmm7, -9072(%rbp)
	vmovsd	.LC5(%rip), %xmm7
	vmovsd	%xmm0, -8696(%rbp)
	vmovsd	%xmm1, -8720(%rbp)
	vmulpd	.LC5(%rip){1to8}, %zmm3, %zmm1
	vmovapd	%zmm1, -8816(%rbp)
	vmulpd	.LC7(%rip), %zmm3, %zmm1
	vmulsd	%xmm4, %xmm7, %xmm7
	vmovsd	%xmm7, -8704(%rbp)
	vmovapd	%zmm1, -8880(%rbp)
	vmovsd	.LC8(%rip), %xmm1
	vmulsd	%xmm4, %xmm1, %xmm1
	vmovq	%xmm1, %r12
	vzeroupper
	call	memset@PLT
	vbroadcastsd	-8560(%rbp), %zmm6
	vmovsd	-2848(%rbp), %xmm4
	vbroadcastsd	-8704(%rbp), %zmm7
	leaq	0(,%rbx,8), %rax
	vmovq	%r12, %xmm1
	vmovapd	-8688(%rbp), %zmm5
	vmovsd	-2856(%rbp), %xmm2
	movq	%rax, -8736(%rbp)
	negq	%rax
	vmovapd	-8624(%rbp), %zmm3
	movq	%rax, -8752(%rbp)
	vbroadcastsd	%xmm1, %zmm1
	movq	$0x000000000, -8744(%rbp)
	vmovapd	%zmm1, -7216(%rbp)
	movq	$0x000000000, -2864(%rbp)
	movq	$0x000000000, -2328(%rbp)
	xorl	%ecx, %ecx
	movq	$0x000000000, -2816(%rbp)
	movq	$0x000000000, -2808(%rbp)
	movq	$0x000000000, -3504(%rbp)
	xorl	%r13d, %r13d
	movq	%rcx, %r14
	movq	%rcx, %rsi
	movq	%r13, %r10
	movq	.LC1(%rip), %rax
	vmovapd	%zmm6, -9008(%rbp)
	vbroadcastsd	-8696(%rbp), %zmm6
	vmovsd	%xmm4, -2312(%rbp)
	vxorpd	%xmm4, %xmm4, %xmm4
	vmovapd	%zmm7, -4528(%rbp)
	vmovapd	%zmm5, -4720(%rbp)
	vmovsd	%xmm2, -2320(%rbp)
	vmovapd	%zmm4, -7152(%rbp)
	vmovapd	%zmm4, %zmm30
	vmovapd	%zmm3, -4144(%rbp)
	movq	%rax, -2928(%rbp)
	movq	%rax, -2824(%rbp)
	vmovapd	%zmm4, %zmm28
	vmovapd	%zmm4, -2416(%rbp)
	vmovapd	%zmm4, -2672(%rbp)
	movq	%rax, -4400(%rbp)
	movq	%rax, %r9
	vmovapd	%zmm4, -5232(%rbp)
	vmovapd	%zmm4, -5168(%rbp)
	vmovapd	%zmm4, %zmm24
	vmovapd	%zmm4, %zmm26
	vmovapd	%zmm4, %zmm19
	vmovapd	%zmm4, %zmm20
	vmovapd	%zmm6, -9136(%rbp)
	movq	$0x000000000, -3440(%rbp)
	movq	-2544(%rbp), %r8
	movq	-2480(%rbp), %r11
	vmovapd	%zmm4, -5104(%rbp)
	movq	$0x000000000, -4336(%rbp)
	vmovapd	%zmm4, -7280(%rbp)
	movq	$0x000000000, -6856(%rbp)
	movq	$0x000000000, -6848(%rbp)
	vmovapd	%zmm4, -3184(%rbp)
	movq	%rax, -6840(%rbp)
	vmovapd	%zmm4, -4080(%rbp)
	movq	%rcx, -2840(%rbp)
	vmovapd	%zmm4, -4016(%rbp)
	movq	%rcx, -2832(%rbp)
	vmovapd	%zmm4, -5040(%rbp)
	movq	%rcx, -3376(%rbp)
	vmovapd	%zmm4, -4656(%rbp)
	movq	%rcx, -2352(%rbp)
	vmovapd	%zmm4, -4592(%rbp)
	movq	%rcx, -2336(%rbp)
	vmovapd	%zmm4, -3120(%rbp)
	vmovapd	%zmm4, -2992(%rbp)
	movq	%r8, -9144(%rbp)
	jmp	.L87
	.p2align 4
	.p2align 3
.L128:
	vsubpd	%zmm18, %zmm3, %zmm5
	vsubpd	%zmm17, %zmm2, %zmm3
	vmovapd	-9072(%rbp), %zmm17
	vmovq	%r14, %xmm2
	xorl	%eax, %eax
	vbroadcastsd	%xmm13, %zmm13
	vucomisd	%xmm2, %xmm25
	vmovapd	-9136(%rbp), %zmm25
	setp	%al
	vmovq	%rdx, %xmm2
	vbroadcastsd	%xmm12, %zmm12
	vbroadcastsd	%xmm11, %zmm11
	cmovne	%r15, %rax
	xorl	%edx, %edx
	vbroadcastsd	%xmm16, %zmm16
	decq	%rax
	vfmadd132pd	%zmm17, %zmm8, %zmm13
	vmovq	%r14, %xmm8
	vfmadd132pd	%zmm17, %zmm9, %zmm16
	vucomisd	%xmm8, %xmm2
	setp	%dl
	vpbroadcastq	%rax, %zmm2
	cmovne	%r15, %rdx
	xorl	%eax, %eax
	negq	%rdx
	vpbroadcastq	%rdx, %zmm8
	vpternlogq	$202, %zmm5, %zmm7, %zmm8
	vpandq	%zmm2, %zmm8, %zmm8
	vmovq	%rdi, %xmm2
	vfmadd132pd	%zmm25, %zmm13, %zmm8
	vmulpd	%zmm8, %zmm12, %zmm8
	vmovdqa64	-4592(%rbp), %zmm12
	vfmadd132pd	-8624(%rbp), %zmm8, %zmm11
	vmovq	%r14, %xmm8
	vbroadcastsd	%xmm2, %zmm5
	vucomisd	%xmm8, %xmm20
	setp	%al
	vbroadcastsd	%xmm21, %zmm2
	vmovapd	%zmm11, -4144(%rbp)
	cmovne	%r15, %rax
	xorl	%edx, %edx
	decq	%rax
	vucomisd	%xmm8, %xmm19
	setp	%dl
	cmovne	%r15, %rdx
	negq	%rdx
	vpbroadcastq	%rdx, %zmm8
	vpternlogq	$202, %zmm3, %zmm12, %zmm8
	vpbroadcastq	%rax, %zmm3
	vpandq	%zmm3, %zmm8, %zmm8
	vfmadd132pd	%zmm25, %zmm16, %zmm8
	vmulpd	%zmm8, %zmm2, %zmm2
	vfmadd132pd	-8688(%rbp), %zmm2, %zmm5
	vmovapd	%zmm5, -4720(%rbp)
.L76:
	vmulpd	616(%rbx){1to8}, %zmm27, %zmm12
	vmovsd	768(%rbx), %xmm5
	vmovq	%r13, %xmm21
	vsubsd	%xmm6, %xmm0, %xmm6
	vbroadcastsd	760(%rbx), %zmm3
	vmovapd	-3888(%rbp), %zmm19
	vucomisd	%xmm0, %xmm0
	vmovsd	-2816(%rbp), %xmm25
	vmovsd	-2808(%rbp), %xmm8
	vmovq	%xmm6, %rax
	vmulsd	%xmm4, %xmm1, %xmm2
	vmulsd	%xmm10, %xmm1, %xmm9
	cmovp	%r14, %rax
	vmovq	%rax, %xmm6
	xorl	%eax, %eax
	vfnmadd231sd	%xmm2, %xmm10, %xmm30
	vmovsd	%xmm5, -8216(%rbp)
	vmovsd	624(%rbx), %xmm5
	vmulpd	%zmm19, %zmm3, %zmm13
	vmovapd	%zmm3, -7664(%rbp)
	vmulsd	%xmm22, %xmm1, %xmm3
	vmovsd	%xmm30, %xmm30, %xmm17
	vfnmadd231sd	%xmm3, %xmm10, %xmm25
	vfnmadd231sd	%xmm3, %xmm15, %xmm29
	vmovsd	%xmm5, -8224(%rbp)
	vmovsd	632(%rbx), %xmm5
	vmovsd	%xmm9, 832(%r12)
	vmovsd	%xmm3, 848(%r12)
	vmovsd	%xmm2, 856(%r12)
	vmovsd	%xmm29, -2816(%rbp)
	vmovsd	%xmm5, -8232(%rbp)
	vsubpd	%zmm13, %zmm12, %zmm5
	vsubpd	%zmm12, %zmm13, %zmm13
	vaddpd	%zmm7, %zmm5, %zmm5
	vmulsd	%xmm15, %xmm1, %xmm7
	vmulsd	%xmm14, %xmm1, %xmm1
	vmovsd	%xmm7, 840(%r12)
	vfnmadd231sd	%xmm7, %xmm15, %xmm21
	vmovsd	%xmm1, 864(%r12)
	vmovsd	792(%rbx), %xmm11
	vmulpd	784(%rbx){1to8}, %zmm19, %zmm20
	vaddpd	%zmm13, %zmm5, %zmm5
	vbroadcastsd	616(%rbx), %zmm16
	vfnmadd231sd	%xmm7, %xmm10, %xmm8
	vmulpd	776(%rbx){1to8}, %zmm19, %zmm18
	vfmsub231pd	-3376(%rbp), %zmm16, %zmm18
	vfnmadd132sd	%xmm1, %xmm26, %xmm14
	vmovq	%xmm21, %r13
	vmovq	%rcx, %xmm21
	vfnmadd231sd	%xmm2, %xmm15, %xmm21
	vmovsd	%xmm11, -8240(%rbp)
	vmovsd	800(%rbx), %xmm11
	vmovq	%xmm14, %rdi
	vfmsub231pd	%zmm24, %zmm16, %zmm20
	vmovsd	%xmm11, -8248(%rbp)
	vmovsd	808(%rbx), %xmm11
	vmovsd	%xmm11, -8256(%rbp)
	vmovsd	-2608(%rbp), %xmm11
	vmovsd	%xmm25, -2608(%rbp)
	vfnmadd231sd	%xmm9, %xmm10, %xmm11
	vfnmadd213sd	-2824(%rbp), %xmm1, %xmm10
	vmovsd	%xmm21, -2824(%rbp)
	vfnmadd213sd	-2832(%rbp), %xmm1, %xmm15
	vbroadcastsd	840(%rbx), %zmm29
	vmovapd	%zmm29, -6448(%rbp)
	vmovapd	%zmm29, %zmm14
	vmovsd	%xmm15, -2832(%rbp)
	vmovq	%rsi, %xmm15
	vfnmadd231sd	%xmm3, %xmm22, %xmm15
	vmovsd	%xmm15, -4336(%rbp)
	vmovapd	-4144(%rbp), %zmm15
	vfmadd231pd	%zmm18, %zmm16, %zmm15
	vmovapd	%zmm15, %zmm25
	vmovq	%r14, %xmm15
	vucomisd	824(%rbx), %xmm15
	vfnmadd231pd	816(%rbx){1to8}, %zmm19, %zmm25
	vmulpd	.LC31(%rip), %zmm25, %zmm13
	vmovsd	848(%rbx), %xmm15
	setp	%al
	cmovne	%r15, %rax
	vmovsd	%xmm15, -8264(%rbp)
	vmovsd	856(%rbx), %xmm15
	negq	%rax
	vucomisd	%xmm0, %xmm0
	vpbroadcastq	%rax, %zmm12
	vmovapd	%zmm13, -6320(%rbp)
	vfnmadd132pd	-6320(%rbp), %zmm20, %zmm14
	vmovapd	%zmm14, -6832(%rbp)
	vpandq	%zmm5, %zmm12, %zmm12
	vbroadcastsd	832(%rbx), %zmm5
	vmovsd	%xmm15, -8272(%rbp)
	vmovsd	864(%rbx), %xmm15
	vmovapd	%zmm5, %zmm30
	vmovapd	%zmm5, -5424(%rbp)
	vfnmadd132pd	%zmm13, %zmm18, %zmm30
	vmovq	%r9, %xmm13
	vmulpd	%zmm29, %zmm30, %zmm26
	vfnmadd231sd	%xmm2, %xmm22, %xmm13
	vfnmadd213sd	-2840(%rbp), %xmm1, %xmm22
	vmovsd	%xmm15, -8280(%rbp)
	vmovsd	-2336(%rbp), %xmm15
	vmovq	%xmm13, %rcx
	vmovq	%r8, %xmm13
	vfnmadd231sd	%xmm2, %xmm4, %xmm13
	vfnmadd213sd	-3504(%rbp), %xmm1, %xmm4
	vmovq	%xmm13, %r9
	vmovsd	%xmm22, -2840(%rbp)
	vmulpd	-5424(%rbp), %zmm14, %zmm22
	vmovq	%xmm4, %r8
	vmovsd	-2312(%rbp), %xmm4
	vmulsd	%xmm4, %xmm7, %xmm5
	vmulsd	%xmm4, %xmm3, %xmm19
	vfmsub231sd	-2608(%rbp), %xmm15, %xmm19
	vmulsd	%xmm4, %xmm2, %xmm21
	vmulsd	%xmm4, %xmm1, %xmm13
	vmulsd	%xmm4, %xmm9, %xmm4
	vfmsub231sd	%xmm15, %xmm8, %xmm5
	vfmsub231sd	%xmm15, %xmm17, %xmm21
	vfmsub231sd	%xmm15, %xmm11, %xmm4
	vfmsub231sd	%xmm15, %xmm10, %xmm13
	vmulsd	%xmm4, %xmm9, %xmm15
	vmulsd	%xmm4, %xmm2, %xmm14
	vmovq	%xmm13, %rsi
	vmovsd	%xmm15, -3504(%rbp)
	vmulsd	%xmm4, %xmm7, %xmm15
	vmulsd	%xmm4, %xmm3, %xmm13
	vmulsd	%xmm4, %xmm1, %xmm4
	vmovsd	%xmm15, -4400(%rbp)
	vmulsd	%xmm5, %xmm7, %xmm15
	vmovsd	%xmm15, -4656(%rbp)
	vmulsd	%xmm5, %xmm3, %xmm15
	vmovsd	%xmm15, -6576(%rbp)
	vmulsd	%xmm5, %xmm2, %xmm15
	vmulsd	%xmm5, %xmm1, %xmm5
	vmovsd	%xmm15, -6872(%rbp)
	vmulsd	%xmm19, %xmm3, %xmm15
	vmovsd	%xmm15, -6960(%rbp)
	vmulsd	%xmm19, %xmm2, %xmm15
	vmulpd	912(%rbx){1to8}, %zmm25, %zmm29
	vmulsd	%xmm21, %xmm2, %xmm25
	vmovsd	%xmm15, -7024(%rbp)
	vmulsd	%xmm19, %xmm1, %xmm15
	vmulsd	%xmm21, %xmm1, %xmm21
	vmulpd	872(%rbx){1to8}, %zmm30, %zmm19
	vmovsd	%xmm15, -7088(%rbp)
	vmovsd	880(%rbx), %xmm15
	vmovsd	%xmm15, -8288(%rbp)
	vmovsd	888(%rbx), %xmm15
	vmovsd	%xmm15, -8296(%rbp)
	vmovsd	896(%rbx), %xmm15
	vmovsd	%xmm15, -8304(%rbp)
	vmovsd	904(%rbx), %xmm15
	vmovsd	%xmm15, -8312(%rbp)
	vmovq	%rsi, %xmm15
	vmulsd	%xmm15, %xmm1, %xmm15
	vmovq	%xmm15, %rsi
	jp	.L116
	vmovsd	-2328(%rbp), %xmm0
	vmovq	%r14, %xmm15
	movl	$1, %eax
	vucomisd	%xmm15, %xmm0
	setp	%dl
	vxorpd	%xmm0, %xmm0, %xmm0
	cmove	%edx, %eax
	movzbl	%al, %eax
	vcvtusi2sdl	%eax, %xmm0, %xmm0
.L78:
	vfmadd231sd	%xmm9, %xmm6, %xmm31
	vsubsd	-3504(%rbp), %xmm11, %xmm11
	vsubsd	-4400(%rbp), %xmm8, %xmm8
	vfmadd231sd	%xmm7, %xmm6, %xmm23
	vmovsd	-2608(%rbp), %xmm15
	vsubsd	%xmm4, %xmm10, %xmm4
	vmovq	%r13, %xmm10
	vsubsd	-4656(%rbp), %xmm10, %xmm10
	vsubsd	%xmm14, %xmm17, %xmm14
	vmovsd	%xmm31, 992(%r12)
	vmovsd	%xmm31, -2336(%rbp)
	vmovsd	-6840(%rbp), %xmm31
	vmovsd	%xmm23, 1000(%r12)
	vmovsd	%xmm23, -2808(%rbp)
	vsubsd	%xmm13, %xmm15, %xmm13
	vmovsd	-2816(%rbp), %xmm15
	vmovsd	%xmm11, 920(%r12)
	vmovsd	%xmm8, 928(%r12)
	vbroadcastsd	912(%rbx), %zmm23
	vfmadd231sd	%xmm3, %xmm6, %xmm31
	vmovsd	%xmm31, -6840(%rbp)
	vmovsd	-6848(%rbp), %xmm31
	vmulpd	%zmm23, %zmm18, %zmm18
	vmulpd	%zmm23, %zmm20, %zmm20
	vmovapd	%zmm23, -6512(%rbp)
	vfmadd231sd	%xmm2, %xmm6, %xmm31
	vmovsd	%xmm31, -6848(%rbp)
	vmovsd	-6856(%rbp), %xmm31
	vfmadd231sd	%xmm1, %xmm6, %xmm31
	vmovsd	%xmm31, -6856(%rbp)
	vsubpd	%zmm29, %zmm12, %zmm31
	vmovsd	848(%rbx), %xmm12
	vmovapd	%zmm31, %zmm29
	vfmadd132pd	832(%rbx){1to8}, %zmm27, %zmm29
	vmovsd	%xmm12, -8320(%rbp)
	vmovsd	856(%rbx), %xmm12
	vmovsd	%xmm12, -8328(%rbp)
	vmovsd	864(%rbx), %xmm12
	vmovsd	%xmm12, -8336(%rbp)
	vmovapd	-2544(%rbp), %zmm12
	vfmadd231pd	840(%rbx){1to8}, %zmm31, %zmm12
	vmovsd	%xmm13, 944(%r12)
	vmovsd	%xmm14, 960(%r12)
	vmovsd	%xmm4, 976(%r12)
	vmovsd	%xmm10, 936(%r12)
	vsubsd	-6576(%rbp), %xmm15, %xmm23
	vmovsd	%xmm0, 824(%r12)
	vmovsd	-2824(%rbp), %xmm15
	vsubsd	-6872(%rbp), %xmm15, %xmm17
	vmovsd	-2832(%rbp), %xmm15
	vmovsd	-2328(%rbp), %xmm0
	vsubsd	%xmm5, %xmm15, %xmm5
	vmovsd	-4336(%rbp), %xmm15
	vmovsd	%xmm23, 952(%r12)
	vsubsd	-6960(%rbp), %xmm15, %xmm15
	vmovsd	%xmm17, 968(%r12)
	vmovsd	%xmm5, 984(%r12)
	vmovq	%xmm15, %rax
	vmovq	%rcx, %xmm15
	vsubsd	-7024(%rbp), %xmm15, %xmm15
	vmovq	%xmm15, %rcx
	vmovsd	-2840(%rbp), %xmm15
	vsubsd	-7088(%rbp), %xmm15, %xmm15
	vmovq	%xmm15, %rdx
	vmovq	%r9, %xmm15
	vsubsd	%xmm25, %xmm15, %xmm25
	vmovq	%r8, %xmm15
	vsubsd	%xmm21, %xmm15, %xmm15
	vmovq	%rsi, %xmm21
	vmovq	%xmm15, %r9
	vmovq	%rdi, %xmm15
	vsubsd	%xmm21, %xmm15, %xmm15
	vmovq	%xmm15, %rsi
	vmovq	%r14, %xmm15
	vucomisd	%xmm15, %xmm0
	jp	.L129
	je	.L79
.L129:
	vmovsd	912(%rbx), %xmm15
	vmovsd	.LC4(%rip), %xmm0
	vsubpd	%zmm26, %zmm24, %zmm26
	vdivsd	-2328(%rbp), %xmm0, %xmm0
	vmovsd	%xmm15, -6960(%rbp)
	vaddpd	%zmm18, %zmm29, %zmm15
	vaddpd	%zmm20, %zmm12, %zmm29
	vmovapd	-3376(%rbp), %zmm12
	vmovapd	%zmm15, -7024(%rbp)
	vsubpd	%zmm19, %zmm12, %zmm12
	vmovapd	%zmm12, -6576(%rbp)
	vsubpd	%zmm22, %zmm26, %zmm12
	vmovapd	%zmm12, -2608(%rbp)
.L98:
	vmovsd	-2928(%rbp), %xmm18
	vmulsd	%xmm0, %xmm6, %xmm0
	vaddsd	%xmm3, %xmm3, %xmm3
	vaddsd	%xmm1, %xmm1, %xmm1
	vmovsd	-2352(%rbp), %xmm24
	vmovsd	-3440(%rbp), %xmm26
	vaddsd	%xmm7, %xmm7, %xmm7
	vaddsd	%xmm2, %xmm2, %xmm2
	vmulsd	-2328(%rbp), %xmm9, %xmm12
	vaddsd	%xmm9, %xmm9, %xmm9
	vmovsd	%xmm3, 888(%r12)
	vmovsd	.LC4(%rip), %xmm3
	vunpcklpd	%xmm0, %xmm1, %xmm1
	vmovsd	%xmm7, 880(%r12)
	vmovsd	%xmm2, 896(%r12)
	vmovsd	%xmm9, 872(%r12)
	vmovupd	%xmm1, 904(%r12)
	vmulsd	%xmm18, %xmm10, %xmm6
	vmulsd	%xmm18, %xmm23, %xmm7
	vmovsd	%xmm18, %xmm18, %xmm22
	vucomisd	%xmm26, %xmm26
	vfnmadd231sd	-2808(%rbp), %xmm18, %xmm26
	vfnmadd231sd	%xmm24, %xmm8, %xmm6
	vfmadd213sd	-2320(%rbp), %xmm6, %xmm22
	vmulsd	%xmm18, %xmm17, %xmm9
	vmovsd	%xmm12, 816(%r12)
	vmulsd	%xmm18, %xmm8, %xmm12
	vmulsd	%xmm18, %xmm5, %xmm19
	vfnmadd231sd	%xmm24, %xmm11, %xmm12
	vfnmadd231sd	%xmm24, %xmm13, %xmm7
	vfnmadd231sd	%xmm24, %xmm14, %xmm9
	vfnmadd231sd	%xmm24, %xmm4, %xmm19
	vmovsd	%xmm26, %xmm26, %xmm21
	vfmadd231sd	-2336(%rbp), %xmm24, %xmm21
	vmovq	%r9, %xmm26
	vfnmadd231sd	%xmm24, %xmm12, %xmm22
	vdivsd	%xmm22, %xmm3, %xmm0
	vmovq	%xmm0, %rdi
	cmovp	%r14, %rdi
	vmovq	%rdi, %xmm0
	vmovq	%xmm21, %rdi
	vmulsd	%xmm6, %xmm0, %xmm3
	vmulsd	%xmm12, %xmm0, %xmm20
	cmovp	%r14, %rdi
	vmovq	%rdi, %xmm21
	vmulsd	%xmm7, %xmm0, %xmm2
	vfnmadd231sd	%xmm3, %xmm12, %xmm8
	vmovsd	%xmm20, 1008(%r12)
	vmovsd	%xmm3, 1016(%r12)
	vfnmadd231sd	%xmm20, %xmm12, %xmm11
	vmovsd	624(%rbx), %xmm1
	vfnmadd231sd	%xmm3, %xmm6, %xmm10
	vfnmadd231sd	%xmm2, %xmm12, %xmm13
	vfnmadd231sd	%xmm2, %xmm6, %xmm23
	vmovsd	%xmm10, %xmm10, %xmm24
	vmovsd	%xmm1, -7088(%rbp)
	vmovsd	632(%rbx), %xmm1
	vmovsd	%xmm2, 1040(%r12)
	vmovsd	%xmm1, -8344(%rbp)
	vmulsd	%xmm9, %xmm0, %xmm1
	vmulsd	%xmm19, %xmm0, %xmm0
	vfnmadd231sd	%xmm1, %xmm12, %xmm14
	vmovsd	%xmm1, 1048(%r12)
	vfnmadd231sd	%xmm0, %xmm12, %xmm4
	vfnmadd231sd	%xmm1, %xmm6, %xmm17
	vmovsd	%xmm0, 1056(%r12)
	vmovsd	624(%rbx), %xmm15
	vfnmadd132sd	%xmm0, %xmm5, %xmm6
	vmovq	%rax, %xmm12
	vmovsd	%xmm18, %xmm18, %xmm5
	vfnmadd231sd	%xmm2, %xmm7, %xmm12
	vfnmadd231sd	%xmm1, %xmm9, %xmm25
	vfnmadd231sd	%xmm0, %xmm9, %xmm26
	vmulsd	%xmm18, %xmm24, %xmm9
	vmovsd	%xmm15, -8352(%rbp)
	vmovsd	632(%rbx), %xmm15
	vmovsd	%xmm15, -8360(%rbp)
	vmovsd	920(%rbx), %xmm15
	vmovsd	%xmm15, -8368(%rbp)
	vmovsd	928(%rbx), %xmm15
	vmovsd	%xmm15, -8376(%rbp)
	vmovsd	936(%rbx), %xmm15
	vmovsd	%xmm15, -8384(%rbp)
	vmovsd	%xmm12, -2328(%rbp)
	vmovq	%rcx, %xmm12
	vmovsd	944(%rbx), %xmm15
	vfnmadd231sd	%xmm1, %xmm7, %xmm12
	vmovsd	992(%rbx), %xmm10
	movq	1016(%rbx), %r13
	movq	1032(%rbx), %rdi
	vmovsd	%xmm12, -2816(%rbp)
	vmovq	%rdx, %xmm12
	vfnmadd231sd	%xmm0, %xmm7, %xmm12
	vmovq	%rsi, %xmm7
	vfnmadd132sd	%xmm0, %xmm7, %xmm19
	vmovsd	1008(%rbx), %xmm7
	vmovsd	%xmm15, -8392(%rbp)
	vmovsd	952(%rbx), %xmm15
	vmovsd	%xmm10, -8440(%rbp)
	vmovsd	1000(%rbx), %xmm10
	vmovq	%xmm12, %r8
	vmulsd	%xmm18, %xmm17, %xmm12
	vmovsd	%xmm7, -8456(%rbp)
	vmovsd	1024(%rbx), %xmm7
	vmovsd	%xmm15, -8400(%rbp)
	vmovsd	960(%rbx), %xmm15
	vmovsd	%xmm10, -8448(%rbp)
	vmulsd	%xmm18, %xmm23, %xmm10
	vmulsd	%xmm18, %xmm6, %xmm18
	vmovsd	%xmm7, -8464(%rbp)
	vmovsd	1040(%rbx), %xmm7
	vmovsd	%xmm15, -8408(%rbp)
	vmovsd	968(%rbx), %xmm15
	vmovsd	%xmm7, -8472(%rbp)
	vmovsd	1048(%rbx), %xmm7
	vmovsd	%xmm15, -8416(%rbp)
	vmovsd	976(%rbx), %xmm15
	vmovsd	%xmm7, -8480(%rbp)
	vmovsd	1056(%rbx), %xmm7
	vmovsd	%xmm15, -8424(%rbp)
	vmovsd	984(%rbx), %xmm15
	vmovsd	%xmm7, -8488(%rbp)
	vmulsd	%xmm5, %xmm8, %xmm7
	vmovsd	-2352(%rbp), %xmm5
	vmovsd	%xmm15, -8432(%rbp)
	vfnmadd231sd	%xmm5, %xmm11, %xmm7
	vfnmadd231sd	%xmm5, %xmm8, %xmm9
	vfnmadd231sd	%xmm5, %xmm13, %xmm10
	vfnmadd231sd	%xmm5, %xmm14, %xmm12
	vfnmadd231sd	%xmm5, %xmm4, %xmm18
	vmovsd	-2320(%rbp), %xmm5
	vfnmadd231sd	%xmm5, %xmm20, %xmm7
	vfnmadd231sd	%xmm5, %xmm3, %xmm9
	vfnmadd231sd	%xmm5, %xmm2, %xmm10
	vfnmadd231sd	%xmm5, %xmm1, %xmm12
	vfnmadd231sd	%xmm5, %xmm0, %xmm18
	vmulsd	%xmm7, %xmm20, %xmm5
	vmulsd	%xmm18, %xmm0, %xmm18
	vmovsd	%xmm5, -2824(%rbp)
	vmulsd	%xmm7, %xmm3, %xmm5
	vmovq	%xmm5, %rcx
	vmulsd	%xmm7, %xmm2, %xmm5
	vmovq	%xmm5, %rsi
	vmulsd	%xmm7, %xmm1, %xmm5
	vmulsd	%xmm7, %xmm0, %xmm7
	vmovsd	%xmm5, -2928(%rbp)
	vmulsd	%xmm9, %xmm3, %xmm5
	vmovq	%xmm5, %r9
	vmulsd	%xmm9, %xmm2, %xmm5
	vmovsd	%xmm5, -3440(%rbp)
	vmulsd	%xmm9, %xmm1, %xmm5
	vmulsd	%xmm9, %xmm0, %xmm9
	vmovsd	%xmm5, -3504(%rbp)
	vmulsd	%xmm10, %xmm2, %xmm5
	vmovsd	%xmm5, -4400(%rbp)
	vmulsd	%xmm10, %xmm1, %xmm5
	vmulsd	%xmm10, %xmm0, %xmm10
	vmovsd	%xmm5, -4656(%rbp)
	vmulsd	%xmm12, %xmm1, %xmm5
	vmulsd	%xmm12, %xmm0, %xmm12
	vmovsd	%xmm5, -6872(%rbp)
	jp	.L117
	vmovq	%r14, %xmm5
	movl	$1, %eax
	vucomisd	%xmm5, %xmm22
	setp	%dl
	vxorpd	%xmm5, %xmm5, %xmm5
	cmove	%edx, %eax
	movzbl	%al, %eax
	vcvtusi2sdl	%eax, %xmm5, %xmm5
.L83:
	vmovsd	%xmm22, 1024(%r12)
	vmovsd	1048(%rbx), %xmm15
	vsubsd	-2824(%rbp), %xmm11, %xmm11
	vsubsd	%xmm9, %xmm6, %xmm6
	vsubsd	%xmm7, %xmm4, %xmm4
	movq	1008(%rbx), %rdx
	movq	1016(%rbx), %rax
	vmovsd	%xmm15, -8496(%rbp)
	vmovsd	1056(%rbx), %xmm15
	vmovsd	%xmm15, -8504(%rbp)
	vmovsd	1040(%rbx), %xmm15
	vmovsd	%xmm15, -8512(%rbp)
	vmovsd	1064(%rbx), %xmm15
	vmovsd	%xmm15, -8520(%rbp)
	vmovsd	1072(%rbx), %xmm15
	vmovsd	%xmm15, -8528(%rbp)
	vmovsd	1080(%rbx), %xmm15
	vmovsd	%xmm15, -8536(%rbp)
	vmovsd	1088(%rbx), %xmm15
	vmovsd	%xmm15, -8544(%rbp)
	vmovsd	1096(%rbx), %xmm15
	vmovsd	%xmm15, -8552(%rbp)
	vmovsd	-2336(%rbp), %xmm15
	vfmadd231sd	%xmm20, %xmm21, %xmm15
	vmovsd	%xmm15, -2336(%rbp)
	vmovsd	-2808(%rbp), %xmm15
	vfmadd231sd	%xmm3, %xmm21, %xmm15
	vmovsd	%xmm15, -2352(%rbp)
	vmovsd	-6840(%rbp), %xmm15
	vmovsd	%xmm11, -6840(%rbp)
	vmovq	%rcx, %xmm11
	vsubsd	%xmm11, %xmm8, %xmm11
	vmovq	%rsi, %xmm8
	vsubsd	%xmm8, %xmm13, %xmm8
	vmovq	%xmm11, %rcx
	vsubsd	-2928(%rbp), %xmm14, %xmm11
	vmovq	%xmm8, %rsi
	vfmadd231sd	%xmm2, %xmm21, %xmm15
	vmovsd	%xmm15, -3376(%rbp)
	vmovsd	-6848(%rbp), %xmm15
	vfmadd231sd	%xmm1, %xmm21, %xmm15
	vmovsd	%xmm15, -2832(%rbp)
	vmovsd	-6856(%rbp), %xmm15
	vfmadd231sd	%xmm0, %xmm21, %xmm15
	vmovsd	%xmm15, -2840(%rbp)
	vmovsd	%xmm11, -6848(%rbp)
	vsubsd	-3504(%rbp), %xmm17, %xmm7
	vmovsd	%xmm6, -3504(%rbp)
	vmovsd	%xmm4, -6856(%rbp)
	vmovq	%r9, %xmm4
	vmovsd	-2328(%rbp), %xmm6
	vsubsd	%xmm4, %xmm24, %xmm4
	vsubsd	-4400(%rbp), %xmm6, %xmm6
	vmovq	%xmm4, %r9
	vsubsd	-3440(%rbp), %xmm23, %xmm4
	vmovsd	%xmm7, -3440(%rbp)
	vmovsd	%xmm6, -4400(%rbp)
	vmovsd	-2816(%rbp), %xmm6
	vsubsd	-4656(%rbp), %xmm6, %xmm6
	vmovsd	%xmm4, -4336(%rbp)
	vmovsd	1104(%rbx), %xmm4
	vmovsd	%xmm5, 1032(%r12)
	vmovq	%r14, %xmm5
	vucomisd	%xmm5, %xmm22
	vmovsd	%xmm6, -2808(%rbp)
	vmovq	%r8, %xmm6
	vsubsd	%xmm10, %xmm6, %xmm6
	vmovsd	%xmm6, -2816(%rbp)
	vsubsd	-6872(%rbp), %xmm25, %xmm6
	vmovsd	%xmm6, -2824(%rbp)
	vsubsd	%xmm12, %xmm26, %xmm6
	vmovsd	%xmm6, -2328(%rbp)
	vsubsd	%xmm18, %xmm19, %xmm6
	vmovsd	%xmm6, -2928(%rbp)
	jp	.L84
	vxorpd	%xmm5, %xmm5, %xmm5
	je	.L88
.L84:
	vmovsd	.LC4(%rip), %xmm5
	vdivsd	%xmm22, %xmm5, %xmm5
.L88:
	vmovsd	-2336(%rbp), %xmm6
	vaddsd	%xmm3, %xmm3, %xmm3
	vmulsd	%xmm5, %xmm21, %xmm5
	vaddsd	%xmm1, %xmm1, %xmm1
	vaddsd	%xmm0, %xmm0, %xmm0
	vmovsd	%xmm3, 1072(%r12)
	vmovsd	-2352(%rbp), %xmm3
	vaddsd	%xmm20, %xmm20, %xmm20
	vaddsd	%xmm2, %xmm2, %xmm2
	vmovsd	%xmm1, 1088(%r12)
	vmovsd	%xmm20, 1064(%r12)
	vmovsd	%xmm2, 1080(%r12)
	vmovsd	1104(%rbx), %xmm24
	vmovsd	%xmm0, 1096(%r12)
	vmovsd	%xmm5, 1104(%r12)
	vaddsd	%xmm6, %xmm6, %xmm0
	vmovsd	%xmm0, 1112(%r12)
	vaddsd	%xmm3, %xmm3, %xmm0
	vmulsd	%xmm3, %xmm3, %xmm1
	vmovsd	%xmm0, 1120(%r12)
	vmulsd	%xmm6, %xmm6, %xmm0
	vaddsd	-2864(%rbp), %xmm0, %xmm0
	vmovsd	1112(%rbx), %xmm9
	vmovsd	1120(%rbx), %xmm11
	vaddsd	%xmm1, %xmm0, %xmm3
	vmovsd	%xmm3, -2864(%rbp)
	testq	%r10, %r10
	je	.L118
	vmovapd	-7408(%rbp), %zmm6
	vmovq	%r14, %xmm22
	vbroadcastsd	%xmm4, %zmm4
	vbroadcastsd	%xmm24, %zmm24
	vmulpd	-2800(%rbp), %zmm6, %zmm1
	vmovapd	-7472(%rbp), %zmm6
	vbroadcastsd	-8288(%rbp), %zmm8
	vmovapd	-5104(%rbp), %zmm0
	vbroadcastsd	-6880(%rbp), %zmm7
	vbroadcastsd	-8032(%rbp), %zmm2
	vfmadd132pd	-2480(%rbp), %zmm1, %zmm6
	vaddpd	%zmm6, %zmm6, %zmm1
	vmovapd	-7280(%rbp), %zmm6
	vmulpd	-5488(%rbp), %zmm7, %zmm7
	vfmadd132pd	.LC7(%rip), %zmm6, %zmm0
	vmovapd	-7344(%rbp), %zmm6
	vbroadcastsd	-7792(%rbp), %zmm3
	vfmadd132pd	-5168(%rbp), %zmm0, %zmm6
	vmovapd	%zmm6, %zmm0
	vmovapd	-2736(%rbp), %zmm6
	vbroadcastsd	-7760(%rbp), %zmm5
	vfmadd132pd	-5232(%rbp), %zmm0, %zmm6
	vmovapd	%zmm6, %zmm0
	vmovapd	-5552(%rbp), %zmm6
	vfmadd132pd	.LC7(%rip), %zmm0, %zmm6
	vmovapd	%zmm6, %zmm0
	vbroadcastsd	-7736(%rbp), %zmm6
	vfmadd132pd	-5616(%rbp), %zmm0, %zmm6
	vbroadcastsd	-7744(%rbp), %zmm0
	vfmadd132pd	-5680(%rbp), %zmm6, %zmm0
	vbroadcastsd	-6896(%rbp), %zmm6
	vmovapd	%zmm8, %zmm15
	vmovq	%rax, %xmm8
	vfmadd132pd	-4976(%rbp), %zmm0, %zmm6
	vbroadcastsd	-6888(%rbp), %zmm0
	xorl	%eax, %eax
	vbroadcastsd	%xmm8, %zmm8
	vfmadd132pd	-7728(%rbp), %zmm7, %zmm0
	vfmadd132pd	-7216(%rbp), %zmm6, %zmm0
	vaddpd	%zmm1, %zmm0, %zmm0
	vfnmadd132pd	-4208(%rbp), %zmm0, %zmm5
	vfnmadd132pd	-6640(%rbp), %zmm5, %zmm3
	vfnmadd132pd	-6768(%rbp), %zmm3, %zmm2
	vfnmadd132pd	-6832(%rbp), %zmm2, %zmm15
	vbroadcastsd	-7088(%rbp), %zmm10
	vmulpd	-6576(%rbp), %zmm10, %zmm3
	vmovapd	-3696(%rbp), %zmm7
	vmovapd	%zmm15, -5168(%rbp)
	vmovapd	%zmm8, -5488(%rbp)
	vmovapd	-3632(%rbp), %zmm12
	vbroadcastsd	-8344(%rbp), %zmm2
	vbroadcastsd	-8376(%rbp), %zmm6
	vmovapd	-2608(%rbp), %zmm13
	vbroadcastsd	-8368(%rbp), %zmm5
	vbroadcastsd	-8456(%rbp), %zmm23
	vbroadcastsd	-8352(%rbp), %zmm1
	vbroadcastsd	-8360(%rbp), %zmm0
	vmovapd	-7024(%rbp), %zmm19
	vfmsub231pd	%zmm13, %zmm2, %zmm3
	vfnmadd231pd	%zmm7, %zmm6, %zmm3
	vmovapd	%zmm6, %zmm17
	vfnmadd132pd	%zmm12, %zmm3, %zmm5
	vbroadcastsd	-8384(%rbp), %zmm3
	vmovapd	%zmm5, %zmm21
	vmulpd	%zmm13, %zmm10, %zmm5
	vmulpd	%zmm12, %zmm23, %zmm6
	vfmsub231pd	%zmm15, %zmm2, %zmm5
	vfnmadd132pd	%zmm7, %zmm5, %zmm3
	vfnmadd132pd	%zmm12, %zmm3, %zmm17
	vbroadcastsd	-8464(%rbp), %zmm3
	vmovq	%r13, %xmm5
	vbroadcastsd	%xmm5, %zmm5
	vfmadd231pd	%zmm5, %zmm7, %zmm6
	vmovapd	%zmm5, -5104(%rbp)
	vmulpd	%zmm21, %zmm1, %zmm5
	vmulpd	%zmm19, %zmm1, %zmm1
	vfmsub231pd	%zmm17, %zmm0, %zmm5
	vfnmadd132pd	%zmm29, %zmm1, %zmm0
	vbroadcastsd	-8232(%rbp), %zmm1
	vfnmadd132pd	%zmm6, %zmm5, %zmm3
	vaddpd	-4720(%rbp), %zmm3, %zmm20
	vbroadcastsd	-8448(%rbp), %zmm3
	vmovq	%rdx, %xmm5
	vbroadcastsd	%xmm5, %zmm5
	vmovapd	%zmm5, -5232(%rbp)
	vfmadd132pd	%zmm7, %zmm0, %zmm3
	vbroadcastsd	-8440(%rbp), %zmm0
	vfmadd132pd	%zmm12, %zmm3, %zmm0
	vbroadcastsd	-8216(%rbp), %zmm3
	vmulpd	%zmm7, %zmm3, %zmm3
	vfmsub132pd	-2544(%rbp), %zmm3, %zmm1
	vbroadcastsd	-8224(%rbp), %zmm3
	vfnmadd132pd	%zmm27, %zmm1, %zmm3
	vfnmadd231pd	-7664(%rbp), %zmm12, %zmm3
	vaddpd	-4592(%rbp), %zmm3, %zmm3
	vmovq	%rdi, %xmm27
	vucomisd	%xmm22, %xmm27
	setp	%al
	cmovne	%r15, %rax
	incq	%r10
	negq	%rax
	vpbroadcastq	%rax, %zmm1
	vaddpd	%zmm0, %zmm3, %zmm3
	vbroadcastsd	%xmm9, %zmm0
	vpandq	%zmm3, %zmm1, %zmm1
	vmovapd	%zmm4, %zmm3
	vfnmadd231pd	%zmm4, %zmm20, %zmm1
	vmovapd	%zmm19, %zmm4
	vmovapd	%zmm3, -5552(%rbp)
	vfmadd231pd	%zmm5, %zmm1, %zmm4
	vfmadd231pd	%zmm3, %zmm21, %zmm4
	vmovapd	%zmm4, %zmm27
	vmovapd	%zmm4, -4592(%rbp)
	vmovapd	%zmm29, %zmm4
	vfmadd213pd	-7152(%rbp), %zmm27, %zmm0
	vfmadd231pd	%zmm8, %zmm1, %zmm4
	vmovapd	%zmm4, %zmm29
	vfmadd231pd	%zmm3, %zmm17, %zmm29
	vbroadcastsd	%xmm11, %zmm3
	vmovapd	%zmm29, -4656(%rbp)
	vmovapd	%zmm3, %zmm11
	vfmadd132pd	%zmm29, %zmm0, %zmm11
	vmovapd	%zmm11, -7152(%rbp)
	vbroadcastsd	-7752(%rbp), %zmm3
	vmovapd	-7920(%rbp), %zmm25
	vmovapd	-7856(%rbp), %zmm19
	vmovapd	-3184(%rbp), %zmm0
	vfnmadd213pd	-3568(%rbp), %zmm3, %zmm19
	vmovapd	-5360(%rbp), %zmm29
	vfnmadd213pd	-2672(%rbp), %zmm19, %zmm0
	vfnmadd231pd	-3312(%rbp), %zmm3, %zmm0
	vmovapd	%zmm0, %zmm11
	vbroadcastsd	-7776(%rbp), %zmm0
	vmovapd	-3248(%rbp), %zmm4
	vbroadcastsd	-7784(%rbp), %zmm5
	vmovapd	%zmm11, -2480(%rbp)
	vfnmadd213pd	-2416(%rbp), %zmm19, %zmm4
	vfnmadd231pd	-3952(%rbp), %zmm3, %zmm4
	vmovapd	-6000(%rbp), %zmm27
	vmovapd	-7984(%rbp), %zmm18
	vmovapd	-5744(%rbp), %zmm14
	vmovapd	-8176(%rbp), %zmm15
	vmovapd	-5296(%rbp), %zmm12
	vfnmadd213pd	-3760(%rbp), %zmm3, %zmm14
	vfnmadd231pd	-3056(%rbp), %zmm19, %zmm14
	vmovapd	%zmm25, %zmm26
	vfnmadd213pd	-4848(%rbp), %zmm5, %zmm25
	vfnmadd132pd	%zmm0, %zmm11, %zmm26
	vfnmadd231pd	%zmm29, %zmm26, %zmm4
	vmovapd	%zmm4, %zmm8
	vmovapd	-5936(%rbp), %zmm4
	vbroadcastsd	-8024(%rbp), %zmm11
	vfnmadd231pd	%zmm27, %zmm0, %zmm8
	vmovapd	%zmm8, -2416(%rbp)
	vfnmadd231pd	%zmm18, %zmm0, %zmm14
	vfnmadd213pd	-4016(%rbp), %zmm5, %zmm18
	vmovapd	%zmm18, %zmm6
	vfnmadd231pd	%zmm12, %zmm26, %zmm14
	vfnmadd231pd	%zmm25, %zmm12, %zmm6
	vfnmadd231pd	%zmm25, %zmm29, %zmm4
	vmovapd	-8112(%rbp), %zmm29
	vmovapd	%zmm4, %zmm9
	vbroadcastsd	-8008(%rbp), %zmm4
	vfnmadd231pd	%zmm27, %zmm5, %zmm9
	vbroadcastsd	-8016(%rbp), %zmm27
	vmovapd	%zmm9, -2544(%rbp)
	vmovapd	%zmm29, %zmm7
	vmovapd	%zmm29, %zmm13
	vmovapd	%zmm4, -3056(%rbp)
	vfnmadd213pd	-4912(%rbp), %zmm11, %zmm29
	vfnmadd132pd	%zmm27, %zmm9, %zmm7
	vmovapd	%zmm7, -2672(%rbp)
	vmovapd	-6192(%rbp), %zmm18
	vfnmadd132pd	%zmm4, %zmm8, %zmm13
	vbroadcastsd	-8248(%rbp), %zmm9
	vfnmadd231pd	%zmm15, %zmm4, %zmm14
	vfnmadd231pd	%zmm15, %zmm27, %zmm6
	vfnmadd231pd	%zmm13, %zmm28, %zmm14
	vfnmadd231pd	%zmm7, %zmm28, %zmm6
	vbroadcastsd	-8240(%rbp), %zmm7
	vmulpd	%zmm14, %zmm16, %zmm8
	vmovapd	%zmm11, -3248(%rbp)
	vmovapd	%zmm25, -3312(%rbp)
	vfnmadd231pd	%zmm11, %zmm15, %zmm18
	vmovapd	%zmm18, %zmm4
	vbroadcastsd	-8264(%rbp), %zmm11
	vfnmadd231pd	%zmm29, %zmm28, %zmm4
	vmovapd	-3888(%rbp), %zmm28
	vmovapd	%zmm9, %zmm18
	vbroadcastsd	-8256(%rbp), %zmm9
	vfnmadd231pd	%zmm30, %zmm11, %zmm14
	vmovapd	%zmm14, %zmm22
	vmovapd	-5424(%rbp), %zmm14
	vmovapd	%zmm11, %zmm12
	vfnmadd132pd	%zmm28, %zmm8, %zmm7
	vmulpd	%zmm6, %zmm16, %zmm8
	vmovapd	%zmm9, %zmm15
	vbroadcastsd	-8280(%rbp), %zmm9
	vfnmadd132pd	%zmm28, %zmm8, %zmm18
	vmulpd	%zmm4, %zmm16, %zmm8
	vmovapd	-4208(%rbp), %zmm16
	vmovapd	%zmm18, -3184(%rbp)
	vfnmadd213pd	-3824(%rbp), %zmm3, %zmm16
	vfnmadd132pd	%zmm28, %zmm8, %zmm15
	vbroadcastsd	-8272(%rbp), %zmm8
	vmovapd	%zmm15, %zmm28
	vmovapd	-6320(%rbp), %zmm15
	vmovapd	%zmm28, -3760(%rbp)
	vfnmadd231pd	%zmm30, %zmm9, %zmm4
	vfnmadd132pd	%zmm15, %zmm7, %zmm12
	vfnmadd231pd	%zmm15, %zmm8, %zmm18
	vfnmadd132pd	%zmm9, %zmm28, %zmm15
	vfnmadd231pd	%zmm14, %zmm15, %zmm4
	vmovapd	%zmm4, -2736(%rbp)
	vmovapd	%zmm16, %zmm4
	vmovapd	-6640(%rbp), %zmm16
	vfnmadd231pd	%zmm14, %zmm12, %zmm22
	vfnmadd231pd	-3120(%rbp), %zmm19, %zmm4
	vfnmadd231pd	%zmm30, %zmm8, %zmm6
	vmovapd	%zmm26, -3120(%rbp)
	vmovapd	-7600(%rbp), %zmm30
	vfnmadd231pd	%zmm14, %zmm18, %zmm6
	vmovapd	-6832(%rbp), %zmm14
	vmovapd	%zmm6, %zmm28
	vmovapd	-3056(%rbp), %zmm6
	vfnmadd231pd	%zmm16, %zmm0, %zmm4
	vfnmadd231pd	-2992(%rbp), %zmm26, %zmm4
	vmovapd	-6768(%rbp), %zmm26
	vfnmadd213pd	-4080(%rbp), %zmm5, %zmm16
	vfnmadd231pd	%zmm26, %zmm6, %zmm4
	vfnmadd231pd	%zmm30, %zmm13, %zmm4
	vfnmadd231pd	%zmm14, %zmm11, %zmm4
	vmovapd	%zmm4, %zmm6
	vmovapd	%zmm16, %zmm4
	vmovapd	-2992(%rbp), %zmm16
	vfnmadd231pd	-6448(%rbp), %zmm12, %zmm6
	vmovapd	%zmm6, -2800(%rbp)
	vmovapd	-6256(%rbp), %zmm6
	vfnmadd231pd	%zmm25, %zmm16, %zmm4
	vmovapd	%zmm30, %zmm25
	vfnmadd231pd	%zmm26, %zmm27, %zmm4
	vfnmadd231pd	-2672(%rbp), %zmm30, %zmm4
	vmovapd	-6448(%rbp), %zmm30
	vfnmadd231pd	%zmm14, %zmm8, %zmm4
	vfnmadd231pd	-3248(%rbp), %zmm26, %zmm6
	vbroadcastsd	-8400(%rbp), %zmm16
	vfnmadd231pd	%zmm25, %zmm29, %zmm6
	vfnmadd231pd	%zmm14, %zmm9, %zmm6
	vmovapd	-3632(%rbp), %zmm25
	vbroadcastsd	-8408(%rbp), %zmm26
	vmovapd	%zmm22, -3824(%rbp)
	vmovapd	%zmm24, -4016(%rbp)
	vbroadcastsd	-8192(%rbp), %zmm24
	vmulpd	%zmm22, %zmm10, %zmm14
	vfmsub231pd	-2800(%rbp), %zmm2, %zmm14
	vfnmadd231pd	%zmm30, %zmm18, %zmm4
	vfnmadd231pd	%zmm30, %zmm15, %zmm6
	vmovapd	-3696(%rbp), %zmm30
	vfnmadd231pd	%zmm30, %zmm16, %zmm14
	vbroadcastsd	-8392(%rbp), %zmm16
	vfnmadd132pd	%zmm25, %zmm14, %zmm16
	vmovapd	%zmm16, %zmm22
	vbroadcastsd	-8416(%rbp), %zmm16
	vmulpd	%zmm28, %zmm10, %zmm14
	vmulpd	-2736(%rbp), %zmm10, %zmm10
	vmovapd	%zmm22, -3632(%rbp)
	vfmsub231pd	%zmm4, %zmm2, %zmm14
	vfnmadd231pd	%zmm30, %zmm16, %zmm14
	vmovapd	%zmm25, %zmm16
	vfnmadd132pd	%zmm25, %zmm14, %zmm26
	vbroadcastsd	-8424(%rbp), %zmm25
	vbroadcastsd	-8432(%rbp), %zmm14
	vfmsub132pd	%zmm6, %zmm10, %zmm2
	vmovapd	%zmm25, %zmm10
	vfnmadd231pd	%zmm30, %zmm14, %zmm2
	vfnmadd132pd	%zmm16, %zmm2, %zmm10
	vmulpd	.LC31(%rip), %zmm20, %zmm2
	vbroadcastsd	-8480(%rbp), %zmm20
	vmovapd	%zmm10, %zmm25
	vbroadcastsd	-8472(%rbp), %zmm10
	vbroadcastsd	-8512(%rbp), %zmm30
	vmovapd	%zmm25, -3696(%rbp)
	vfnmadd231pd	-5104(%rbp), %zmm2, %zmm17
	vmovapd	%zmm17, -3888(%rbp)
	vmovapd	%zmm20, %zmm16
	vbroadcastsd	-8488(%rbp), %zmm20
	vmovapd	%zmm10, -3952(%rbp)
	vmovapd	%zmm16, %zmm17
	vmovapd	%zmm16, -4208(%rbp)
	vbroadcastsd	-8504(%rbp), %zmm16
	vfnmadd132pd	%zmm2, %zmm22, %zmm10
	vfnmadd231pd	%zmm2, %zmm23, %zmm21
	vmovapd	%zmm21, %zmm14
	vfnmadd132pd	%zmm2, %zmm26, %zmm17
	vmovapd	-5040(%rbp), %zmm21
	vmovapd	-3568(%rbp), %zmm22
	vmovapd	%zmm30, -2992(%rbp)
	vfnmadd132pd	-5808(%rbp), %zmm21, %zmm3
	vbroadcastsd	-8320(%rbp), %zmm30
	vfnmadd132pd	%zmm20, %zmm25, %zmm2
	vbroadcastsd	-8496(%rbp), %zmm25
	vfmadd231pd	-7536(%rbp), %zmm22, %zmm3
	vmovapd	-2480(%rbp), %zmm22
	vmovapd	-4784(%rbp), %zmm21
	vfmadd231pd	-6704(%rbp), %zmm0, %zmm3
	vfnmadd231pd	-6384(%rbp), %zmm22, %zmm3
	vmovapd	-2416(%rbp), %zmm22
	vfmadd132pd	-4272(%rbp), %zmm3, %zmm24
	vmovapd	-5552(%rbp), %zmm3
	vfnmadd231pd	%zmm21, %zmm22, %zmm24
	vmovapd	-6384(%rbp), %zmm22
	vfmadd132pd	%zmm31, %zmm24, %zmm30
	vmovapd	-6704(%rbp), %zmm24
	vfmadd132pd	-6512(%rbp), %zmm30, %zmm7
	vfmadd213pd	-5872(%rbp), %zmm5, %zmm24
	vfmadd231pd	-2992(%rbp), %zmm1, %zmm7
	vfnmadd231pd	-4848(%rbp), %zmm22, %zmm24
	vfmadd132pd	-3632(%rbp), %zmm7, %zmm3
	vmovapd	-4272(%rbp), %zmm22
	vbroadcastsd	-8328(%rbp), %zmm7
	vmovapd	%zmm3, -5040(%rbp)
	vbroadcastsd	-8200(%rbp), %zmm3
	vmovapd	-4016(%rbp), %zmm30
	vfmadd132pd	%zmm22, %zmm24, %zmm3
	vfnmadd231pd	-2544(%rbp), %zmm21, %zmm3
	vmovapd	-6064(%rbp), %zmm21
	vfmadd132pd	%zmm31, %zmm3, %zmm7
	vmovapd	-6512(%rbp), %zmm3
	vbroadcastsd	-8336(%rbp), %zmm24
	vfmadd132pd	-3184(%rbp), %zmm7, %zmm3
	vfmadd231pd	%zmm1, %zmm25, %zmm3
	vfmadd132pd	%zmm30, %zmm3, %zmm26
	vmovapd	%zmm26, -4016(%rbp)
	vsubpd	-6128(%rbp), %zmm21, %zmm26
	vbroadcastsd	-8208(%rbp), %zmm3
	vbroadcastsd	-6960(%rbp), %zmm7
	vfmadd132pd	%zmm22, %zmm26, %zmm3
	vmovapd	-4784(%rbp), %zmm22
	vfnmadd231pd	-4912(%rbp), %zmm22, %zmm3
	vfmadd132pd	%zmm31, %zmm3, %zmm24
	vmovapd	%zmm30, %zmm31
	vfmadd132pd	-3760(%rbp), %zmm24, %zmm7
	vfmadd132pd	%zmm16, %zmm7, %zmm1
	vfmadd132pd	-3696(%rbp), %zmm1, %zmm31
	vbroadcastsd	-8520(%rbp), %zmm1
	vmovapd	-6576(%rbp), %zmm30
	vmovapd	-5104(%rbp), %zmm21
	vmovapd	-3888(%rbp), %zmm7
	vmovapd	%zmm31, -4080(%rbp)
	vmovapd	-3952(%rbp), %zmm3
	vmovapd	-5168(%rbp), %zmm22
	vfnmadd231pd	%zmm14, %zmm1, %zmm30
	vmovapd	-2608(%rbp), %zmm1
	vfnmadd231pd	%zmm21, %zmm14, %zmm1
	vmovapd	%zmm1, %zmm31
	vmovapd	-3824(%rbp), %zmm1
	vfnmadd231pd	%zmm7, %zmm23, %zmm31
	vmovapd	%zmm31, -3184(%rbp)
	vmovapd	-4208(%rbp), %zmm31
	vfnmadd231pd	%zmm3, %zmm14, %zmm1
	vfnmadd132pd	%zmm10, %zmm1, %zmm23
	vmovapd	%zmm23, %zmm24
	vfnmadd231pd	%zmm31, %zmm14, %zmm28
	vmovapd	%zmm28, %zmm1
	vmovapd	-5232(%rbp), %zmm28
	vfnmadd213pd	-2736(%rbp), %zmm20, %zmm14
	vfnmadd132pd	%zmm7, %zmm4, %zmm31
	vbroadcastsd	-7992(%rbp), %zmm4
	vfnmadd132pd	%zmm7, %zmm6, %zmm20
	vbroadcastsd	-7768(%rbp), %zmm6
	vfnmadd213pd	-3568(%rbp), %zmm19, %zmm6
	vfnmadd231pd	%zmm28, %zmm17, %zmm1
	vmovapd	%zmm1, %zmm26
	vbroadcastsd	-8528(%rbp), %zmm1
	vfnmadd132pd	%zmm2, %zmm14, %zmm28
	vmovapd	-3120(%rbp), %zmm14
	vfnmadd213pd	-2480(%rbp), %zmm14, %zmm5
	vfnmadd132pd	%zmm7, %zmm22, %zmm1
	vmovapd	%zmm1, -7280(%rbp)
	vmovapd	-2800(%rbp), %zmm1
	vfnmadd132pd	%zmm14, %zmm6, %zmm4
	vmovapd	-3312(%rbp), %zmm6
	vfnmadd132pd	%zmm7, %zmm1, %zmm3
	vmovapd	%zmm21, %zmm1
	vbroadcastsd	-8536(%rbp), %zmm7
	vfnmadd132pd	%zmm10, %zmm3, %zmm1
	vmovapd	-5488(%rbp), %zmm3
	vmovapd	%zmm1, -5104(%rbp)
	vmovapd	%zmm31, %zmm1
	vfnmadd132pd	%zmm6, %zmm5, %zmm0
	vfnmadd231pd	%zmm13, %zmm27, %zmm0
	vfnmadd231pd	%zmm3, %zmm17, %zmm1
	vmovapd	%zmm1, -5168(%rbp)
	vmovapd	%zmm20, %zmm1
	vmovapd	%zmm7, %zmm20
	vfnmadd231pd	%zmm3, %zmm2, %zmm1
	vbroadcastsd	-8040(%rbp), %zmm3
	vmovapd	%zmm1, -5232(%rbp)
	vbroadcastsd	-8296(%rbp), %zmm1
	vmovapd	-2672(%rbp), %zmm7
	vfnmadd132pd	%zmm13, %zmm4, %zmm3
	vfnmadd132pd	%zmm12, %zmm3, %zmm1
	vfnmadd132pd	%zmm10, %zmm1, %zmm20
	vmovapd	%zmm20, -3120(%rbp)
	vmovapd	-3056(%rbp), %zmm4
	vmovapd	-3248(%rbp), %zmm5
	vmovapd	-2416(%rbp), %zmm22
	vmovapd	-2992(%rbp), %zmm3
	vbroadcastsd	-8048(%rbp), %zmm1
	vfnmadd231pd	%zmm4, %zmm7, %zmm0
	vfnmadd231pd	%zmm12, %zmm8, %zmm0
	vfnmadd231pd	%zmm18, %zmm11, %zmm0
	vfnmadd231pd	%zmm10, %zmm25, %zmm0
	vfnmadd132pd	%zmm5, %zmm22, %zmm13
	vfnmadd132pd	%zmm29, %zmm13, %zmm4
	vfnmadd132pd	%zmm9, %zmm4, %zmm12
	vbroadcastsd	-8544(%rbp), %zmm4
	vfnmadd231pd	%zmm3, %zmm17, %zmm0
	vmovapd	%zmm0, -2672(%rbp)
	vbroadcastsd	-8304(%rbp), %zmm0
	vfnmadd132pd	%zmm15, %zmm12, %zmm11
	vfnmadd132pd	%zmm16, %zmm11, %zmm10
	vfnmadd231pd	%zmm3, %zmm2, %zmm10
	vbroadcastsd	-8000(%rbp), %zmm3
	vfnmadd213pd	-2544(%rbp), %zmm7, %zmm5
	vfnmadd213pd	-4848(%rbp), %zmm6, %zmm3
	vfnmadd132pd	%zmm7, %zmm3, %zmm1
	vbroadcastsd	-8552(%rbp), %zmm3
	vmovapd	%zmm10, -2416(%rbp)
	vmovapd	%zmm4, %zmm19
	vfnmadd132pd	%zmm18, %zmm1, %zmm0
	vfnmadd132pd	%zmm17, %zmm0, %zmm19
	vmovapd	%zmm5, %zmm0
	vbroadcastsd	-8184(%rbp), %zmm1
	vfnmadd231pd	%zmm29, %zmm27, %zmm0
	vfnmadd132pd	%zmm18, %zmm0, %zmm9
	vbroadcastsd	-8312(%rbp), %zmm0
	vfnmadd132pd	%zmm15, %zmm9, %zmm8
	vfnmadd213pd	-4912(%rbp), %zmm29, %zmm1
	vfnmadd132pd	%zmm17, %zmm8, %zmm16
	vfnmadd132pd	%zmm2, %zmm16, %zmm25
	vmovapd	%zmm25, -2992(%rbp)
	vfnmadd132pd	%zmm15, %zmm1, %zmm0
	vfnmadd132pd	%zmm2, %zmm0, %zmm3
	vmovapd	%zmm3, %zmm20
	cmpq	%r10, -6864(%rbp)
	jb	.L182
.L87:
	movq	%r10, %rbx
	movq	-8728(%rbp), %rax
	andl	$1, %ebx
	imulq	$1128, %rbx, %r12
	xorq	$1, %rbx
	imulq	$1128, %rbx, %rbx
	addq	%rax, %r12
	addq	%rax, %rbx
	cmpq	%r10, -6864(%rbp)
	je	.L4
	movq	-8736(%rbp), %rdi
	movq	%r11, %rax
	addq	%rdi, %r11
.L5:
	vmovsd	24(%rax), %xmm4
	vmovapd	-4656(%rbp), %zmm6
	vmovapd	-4592(%rbp), %zmm2
	movq	(%rax), %r13
	movq	8(%rax), %rdi
	movq	16(%rax), %r8
	vmovsd	%xmm4, -3248(%rbp)
	vmovsd	32(%rax), %xmm4
	vmovsd	%xmm4, -2544(%rbp)
	vmovsd	40(%rax), %xmm4
	vmovsd	%xmm4, -2608(%rbp)
	vmovsd	-2832(%rbp), %xmm4
	vmovsd	%xmm4, 240(%r12)
	vmovsd	-2840(%rbp), %xmm4
	vmovsd	%xmm4, 248(%r12)
	vmovsd	-2808(%rbp), %xmm4
	vmovsd	%xmm4, 200(%r12)
	vbroadcastsd	8(%rbx), %zmm0
	vmulpd	(%rbx){1to8}, %zmm6, %zmm4
	vmulpd	16(%rbx){1to8}, %zmm2, %zmm9
	vbroadcastsd	24(%rbx), %zmm2
	vmulpd	%zmm6, %zmm0, %zmm21
	vmulpd	%zmm9, %zmm0, %zmm0
	vmovsd	-2816(%rbp), %xmm6
	vfmadd231pd	%zmm4, %zmm2, %zmm0
	vmovapd	%zmm0, -5488(%rbp)
	vmulpd	%zmm21, %zmm2, %zmm2
	vmovsd	%xmm6, 208(%r12)
	vmovsd	-2824(%rbp), %xmm6
	vmovsd	%xmm6, 216(%r12)
	vmovsd	-2328(%rbp), %xmm6
	vmovsd	%xmm6, 224(%r12)
	vmovsd	-2928(%rbp), %xmm6
	vmovsd	%xmm6, 232(%r12)
	vmovsd	-2312(%rbp), %xmm6
	vmovsd	%xmm6, 688(%r12)
	vmovsd	-2320(%rbp), %xmm5
	vmovsd	-2352(%rbp), %xmm6
	vandpd	.LC9(%rip), %xmm6, %xmm0
	vmovsd	.LC10(%rip), %xmm3
	vmovsd	%xmm5, 696(%r12)
	vcomisd	%xmm0, %xmm3
	jbe	.L170
	vmovsd	-2352(%rbp), %xmm3
	vmovsd	.LC24(%rip), %xmm7
	vmulsd	.LC11(%rip), %xmm3, %xmm10
	vmovsd	.LC18(%rip), %xmm8
	vmovsd	.LC22(%rip), %xmm11
	vmovsd	.LC16(%rip), %xmm13
	vmovsd	.LC20(%rip), %xmm6
	vmovsd	.LC14(%rip), %xmm12
	vrndscalesd	$4, %xmm10, %xmm10, %xmm10
	vfnmadd231sd	.LC12(%rip), %xmm10, %xmm3
	vcvttsd2sil	%xmm10, %eax
	vmovsd	%xmm3, %xmm3, %xmm5
	vfnmadd231sd	.LC13(%rip), %xmm10, %xmm5
	vmulsd	%xmm5, %xmm5, %xmm1
	vfnmadd213sd	.LC25(%rip), %xmm1, %xmm7
	vfmadd213sd	.LC19(%rip), %xmm1, %xmm8
	vfnmadd213sd	.LC23(%rip), %xmm1, %xmm11
	vfmadd213sd	.LC17(%rip), %xmm1, %xmm13
	vfnmadd213sd	.LC21(%rip), %xmm1, %xmm6
	vfmadd213sd	.LC15(%rip), %xmm1, %xmm12
	vmulsd	%xmm1, %xmm1, %xmm0
	vfmadd231sd	.LC27(%rip), %xmm0, %xmm7
	vfmadd231sd	.LC26(%rip), %xmm0, %xmm8
	vmulsd	%xmm1, %xmm5, %xmm3
	vfmadd132sd	%xmm0, %xmm11, %xmm7
	vfmadd132sd	%xmm0, %xmm13, %xmm8
	vfmadd132sd	%xmm0, %xmm6, %xmm7
	vfmadd132sd	%xmm0, %xmm12, %xmm8
	vmulsd	%xmm7, %xmm0, %xmm0
	vfmsub132sd	.LC28(%rip), %xmm0, %xmm1
	vfmadd132sd	%xmm8, %xmm5, %xmm3
	vmovsd	.LC4(%rip), %xmm5
	vsubsd	%xmm1, %xmm5, %xmm6
	testb	$1, %al
	jne	.L8
	vmovq	%xmm3, %rdx
	vmovsd	%xmm6, %xmm6, %xmm3
	vmovq	%rdx, %xmm6
.L8:
	testb	$2, %al
	je	.L9
	vxorpd	.LC29(%rip), %xmm6, %xmm6
.L9:
	incl	%eax
	testb	$2, %al
	je	.L7
	vxorpd	.LC29(%rip), %xmm3, %xmm3
.L7:
	vmovsd	-2336(%rbp), %xmm5
	vandpd	.LC9(%rip), %xmm5, %xmm0
	vmovsd	.LC10(%rip), %xmm5
	vcomisd	%xmm0, %xmm5
	jbe	.L171
	vmovsd	-2336(%rbp), %xmm7
	vmovsd	.LC24(%rip), %xmm8
	vmulsd	.LC11(%rip), %xmm7, %xmm10
	vmovsd	.LC22(%rip), %xmm12
	vmovsd	.LC16(%rip), %xmm15
	vmovsd	.LC20(%rip), %xmm11
	vmovsd	.LC14(%rip), %xmm14
	vrndscalesd	$4, %xmm10, %xmm10, %xmm10
	vfnmadd231sd	.LC12(%rip), %xmm10, %xmm7
	vcvttsd2sil	%xmm10, %eax
	vmovsd	%xmm7, %xmm7, %xmm5
	vfnmadd231sd	.LC13(%rip), %xmm10, %xmm5
	vmovsd	.LC18(%rip), %xmm7
	vmulsd	%xmm5, %xmm5, %xmm0
	vfnmadd213sd	.LC25(%rip), %xmm0, %xmm8
	vfmadd213sd	.LC19(%rip), %xmm0, %xmm7
	vfnmadd213sd	.LC23(%rip), %xmm0, %xmm12
	vfmadd213sd	.LC17(%rip), %xmm0, %xmm15
	vfnmadd213sd	.LC21(%rip), %xmm0, %xmm11
	vfmadd213sd	.LC15(%rip), %xmm0, %xmm14
	vmulsd	%xmm0, %xmm0, %xmm1
	vfmadd231sd	.LC27(%rip), %xmm1, %xmm8
	vfmadd231sd	.LC26(%rip), %xmm1, %xmm7
	vmulsd	%xmm0, %xmm5, %xmm13
	vfmadd132sd	%xmm1, %xmm12, %xmm8
	vfmadd132sd	%xmm1, %xmm15, %xmm7
	vfmadd132sd	%xmm1, %xmm11, %xmm8
	vfmadd132sd	%xmm1, %xmm14, %xmm7
	vmulsd	%xmm8, %xmm1, %xmm1
	vfmsub132sd	.LC28(%rip), %xmm1, %xmm0
	vfmadd132sd	%xmm13, %xmm5, %xmm7
	vmovsd	.LC4(%rip), %xmm5
	vsubsd	%xmm0, %xmm5, %xmm0
	testb	$1, %al
	jne	.L12
	vmovq	%xmm7, %rdx
	vmovsd	%xmm0, %xmm0, %xmm7
	vmovq	%rdx, %xmm0
.L12:
	testb	$2, %al
	je	.L13
	vxorpd	.LC29(%rip), %xmm0, %xmm0
.L13:
	incl	%eax
	testb	$2, %al
	je	.L11
	vxorpd	.LC29(%rip), %xmm7, %xmm7
.L11:
	vdivsd	%xmm7, %xmm0, %xmm0
	vmovsd	.LC4(%rip), %xmm1
	vmulsd	.LC1(%rip), %xmm3, %xmm8
	vmovapd	%zmm9, %zmm23
	vmulsd	.LC1(%rip), %xmm6, %xmm11
	vmovapd	%zmm30, %zmm16
	vmulpd	.LC7(%rip), %zmm4, %zmm17
	vmovsd	%xmm8, 136(%r12)
	vmovsd	%xmm11, 144(%r12)
	vmulsd	%xmm0, %xmm6, %xmm5
	vmulsd	.LC1(%rip), %xmm5, %xmm7
	vfmadd231sd	%xmm0, %xmm0, %xmm1
	vmulsd	%xmm0, %xmm3, %xmm0
	vmovsd	%xmm5, 32(%r12)
	vmovsd	%xmm1, 16(%r12)
	vmovsd	%xmm0, 40(%r12)
	vmulsd	%xmm0, %xmm6, %xmm14
	vfmsub231sd	%xmm5, %xmm3, %xmm14
	vmovsd	%xmm7, 152(%r12)
	vbroadcastsd	(%rbx), %zmm1
	vmovsd	72(%rbx), %xmm10
	vbroadcastsd	40(%rbx), %zmm25
	vbroadcastsd	8(%rbx), %zmm9
	vbroadcastsd	48(%rbx), %zmm27
	vfmsub132pd	%zmm1, %zmm2, %zmm23
	vmulpd	.LC7(%rip), %zmm21, %zmm2
	vmulpd	.LC7(%rip), %zmm23, %zmm12
	vmovsd	%xmm10, -6888(%rbp)
	vmovapd	%zmm23, -7728(%rbp)
	vmulsd	.LC1(%rip), %xmm0, %xmm10
	vmovapd	%zmm2, -3056(%rbp)
	vmovapd	-5488(%rbp), %zmm2
	vmovapd	%zmm12, -2480(%rbp)
	vmulpd	56(%rbx){1to8}, %zmm4, %zmm12
	vmulpd	.LC7(%rip), %zmm2, %zmm13
	vfnmadd132pd	%zmm21, %zmm12, %zmm27
	vmulpd	%zmm2, %zmm1, %zmm1
	vfnmadd231pd	32(%rbx){1to8}, %zmm21, %zmm1
	vfnmadd132pd	%zmm23, %zmm1, %zmm9
	vfnmadd132pd	%zmm4, %zmm9, %zmm25
	vmovapd	%zmm13, -2800(%rbp)
	vmovsd	64(%rbx), %xmm13
	vmovsd	%xmm10, 160(%r12)
	vmovsd	%xmm13, -6880(%rbp)
	vaddsd	%xmm3, %xmm3, %xmm13
	vmovsd	%xmm13, 48(%r12)
	vaddsd	%xmm6, %xmm6, %xmm13
	vmovsd	%xmm13, 56(%r12)
	vaddsd	%xmm5, %xmm5, %xmm13
	vmovsd	.LC4(%rip), %xmm31
	vmovsd	%xmm13, 64(%r12)
	vaddsd	%xmm0, %xmm0, %xmm13
	vmovsd	%xmm13, 72(%r12)
	vmulsd	%xmm6, %xmm6, %xmm13
	vmulsd	.LC5(%rip), %xmm6, %xmm6
	vfmadd231sd	%xmm3, %xmm3, %xmm13
	vmulsd	.LC8(%rip), %xmm13, %xmm15
	vmulsd	.LC5(%rip), %xmm3, %xmm3
	vfmadd231sd	%xmm5, %xmm5, %xmm31
	vmulsd	.LC5(%rip), %xmm5, %xmm5
	vmovsd	%xmm6, -3696(%rbp)
	vfmadd231sd	%xmm0, %xmm0, %xmm31
	vmulsd	.LC5(%rip), %xmm0, %xmm0
	vmovsd	%xmm15, 80(%r12)
	vmovsd	%xmm15, -3312(%rbp)
	vmovapd	-4976(%rbp), %zmm15
	vbroadcastsd	80(%rbx), %zmm1
	vmovsd	%xmm3, -3632(%rbp)
	vmovsd	112(%rbx), %xmm12
	vbroadcastsd	104(%rbx), %zmm29
	vbroadcastsd	96(%rbx), %zmm13
	vmulpd	128(%rbx){1to8}, %zmm15, %zmm9
	vmovapd	%zmm1, -4208(%rbp)
	vbroadcastsd	88(%rbx), %zmm1
	vmovsd	%xmm0, -3760(%rbp)
	vmovsd	%xmm12, -6896(%rbp)
	vbroadcastsd	120(%rbx), %zmm12
	vmovsd	%xmm3, 96(%r12)
	vmovsd	%xmm5, 120(%r12)
	vmovapd	%zmm9, -3568(%rbp)
	vmovsd	%xmm0, 128(%r12)
	vmovsd	%xmm6, 104(%r12)
	vmulsd	.LC8(%rip), %xmm14, %xmm9
	vmovq	%xmm9, %rax
	vmovsd	%xmm9, 88(%r12)
	vmulsd	.LC8(%rip), %xmm31, %xmm9
	vmovsd	%xmm9, 112(%r12)
	vmovapd	-4528(%rbp), %zmm6
	vbroadcastsd	136(%rbx), %zmm14
	vmovq	%xmm9, %rdx
	vmovapd	-2672(%rbp), %zmm3
	vbroadcastsd	144(%rbx), %zmm15
	vmovsd	-3504(%rbp), %xmm22
	vbroadcastsd	152(%rbx), %zmm18
	vmulpd	%zmm6, %zmm2, %zmm9
	vmovsd	-6848(%rbp), %xmm2
	vfmadd231pd	%zmm26, %zmm14, %zmm16
	vfmadd132pd	%zmm14, %zmm24, %zmm3
	vmovapd	%zmm3, %zmm31
	vfnmadd231pd	-2416(%rbp), %zmm15, %zmm31
	vmovapd	%zmm31, -3952(%rbp)
	vmovsd	-6840(%rbp), %xmm31
	vmovsd	%xmm22, %xmm22, %xmm0
	vfnmadd231pd	%zmm28, %zmm15, %zmm16
	vmovapd	%zmm9, -3824(%rbp)
	vmovapd	%zmm18, -7344(%rbp)
	vmulpd	%zmm23, %zmm6, %zmm9
	vmovsd	-3440(%rbp), %xmm23
	vbroadcastsd	160(%rbx), %zmm6
	vmovapd	%zmm9, -3888(%rbp)
	vmovq	%rsi, %xmm9
	vfmadd231sd	-2808(%rbp), %xmm8, %xmm9
	vfmadd231sd	%xmm2, %xmm8, %xmm31
	vfmadd231sd	-2824(%rbp), %xmm8, %xmm2
	vmovapd	%zmm6, -2736(%rbp)
	vmovsd	-6856(%rbp), %xmm6
	vmovsd	%xmm31, %xmm31, %xmm30
	vmovq	%rcx, %xmm31
	vfmadd231sd	%xmm23, %xmm8, %xmm31
	vfnmadd132sd	%xmm11, %xmm31, %xmm0
	vmovsd	%xmm9, %xmm9, %xmm31
	vmovsd	.LC1(%rip), %xmm9
	vfnmadd231sd	-2816(%rbp), %xmm11, %xmm31
	vfnmadd231sd	%xmm6, %xmm11, %xmm30
	vmovq	%xmm0, %rcx
	vmovsd	-2328(%rbp), %xmm0
	vfnmadd231sd	%xmm0, %xmm11, %xmm2
	vmovsd	%xmm2, %xmm2, %xmm3
	vmovsd	%xmm2, 168(%r12)
	vmovsd	%xmm6, %xmm6, %xmm2
	vmovq	%r9, %xmm6
	vfmadd231sd	-4336(%rbp), %xmm9, %xmm6
	vfmadd231sd	%xmm0, %xmm8, %xmm2
	vfmadd231sd	%xmm3, %xmm8, %xmm30
	vmovsd	%xmm2, %xmm2, %xmm0
	vfnmadd231sd	-2928(%rbp), %xmm11, %xmm0
	vmovapd	-2992(%rbp), %zmm2
	vfmadd231sd	%xmm23, %xmm7, %xmm6
	vmovapd	%zmm14, %zmm23
	vfmadd132pd	%zmm19, %zmm26, %zmm23
	vfmadd132pd	%zmm2, %zmm28, %zmm14
	vfnmadd231pd	%zmm2, %zmm15, %zmm23
	vfnmadd132pd	%zmm20, %zmm14, %zmm15
	vmovapd	-5104(%rbp), %zmm14
	vfmadd231sd	%xmm22, %xmm10, %xmm6
	vmovapd	-3184(%rbp), %zmm22
	vfnmadd231sd	%xmm0, %xmm11, %xmm30
	vmovsd	%xmm0, 176(%r12)
	vfmadd231pd	.LC7(%rip), %zmm24, %zmm22
	vfmadd231pd	%zmm18, %zmm26, %zmm22
	vmovapd	-2736(%rbp), %zmm26
	vfmadd231pd	%zmm26, %zmm28, %zmm22
	vmovapd	-3120(%rbp), %zmm28
	vfmadd132pd	.LC7(%rip), %zmm14, %zmm28
	vmovapd	-2672(%rbp), %zmm24
	vmovapd	%zmm28, %zmm14
	vmovapd	%zmm18, %zmm28
	vmovsd	.LC1(%rip), %xmm2
	vfmadd231pd	%zmm24, %zmm18, %zmm14
	vmovapd	%zmm14, %zmm18
	vmovsd	-4336(%rbp), %xmm14
	vfmadd231pd	-2416(%rbp), %zmm26, %zmm18
	vfmadd231sd	-4400(%rbp), %xmm9, %xmm14
	vmovapd	%zmm18, -5552(%rbp)
	vmovapd	-5168(%rbp), %zmm18
	vfmadd231pd	.LC7(%rip), %zmm24, %zmm18
	vmovsd	-2808(%rbp), %xmm24
	vfmadd231pd	%zmm28, %zmm19, %zmm18
	vmovsd	-2816(%rbp), %xmm9
	vfmadd231sd	%xmm24, %xmm7, %xmm14
	vfmadd231sd	%xmm9, %xmm10, %xmm14
	vmovsd	%xmm14, %xmm14, %xmm26
	vmovsd	-3440(%rbp), %xmm14
	vfmadd231sd	%xmm24, %xmm2, %xmm14
	vfmadd231sd	-2824(%rbp), %xmm7, %xmm14
	vfmadd231sd	-2328(%rbp), %xmm10, %xmm14
	vmovsd	%xmm14, 184(%r12)
	vmovsd	%xmm14, %xmm14, %xmm24
	vmovsd	-3504(%rbp), %xmm14
	vfmadd231sd	%xmm9, %xmm2, %xmm14
	vfmadd231sd	-2328(%rbp), %xmm7, %xmm14
	vmovapd	-2992(%rbp), %zmm2
	vmovapd	%zmm18, %zmm9
	vmovapd	-2736(%rbp), %zmm18
	vfmadd231sd	-2928(%rbp), %xmm10, %xmm14
	vfmadd231pd	%zmm2, %zmm18, %zmm9
	vmovapd	-5232(%rbp), %zmm18
	vmovapd	%zmm9, -5616(%rbp)
	vmovapd	-2416(%rbp), %zmm9
	vfmadd231pd	.LC7(%rip), %zmm9, %zmm18
	vfmadd231pd	%zmm28, %zmm2, %zmm18
	vmovapd	%zmm18, %zmm9
	vfmadd231pd	-2736(%rbp), %zmm20, %zmm9
	vmovapd	%zmm9, -5680(%rbp)
	vmovsd	%xmm14, 192(%r12)
	vmovsd	152(%rbx), %xmm2
	vbroadcastsd	144(%rbx), %zmm28
	vbroadcastsd	136(%rbx), %zmm18
	vmovsd	%xmm2, -7736(%rbp)
	vmovsd	160(%rbx), %xmm2
	vfmadd231pd	%zmm23, %zmm18, %zmm16
	vfnmadd231pd	%zmm15, %zmm28, %zmm16
	vmovsd	%xmm2, -7744(%rbp)
	vmovapd	-5616(%rbp), %zmm2
	vfmadd231sd	.LC1(%rip), %xmm26, %xmm6
	vfmadd132pd	%zmm2, %zmm22, %zmm18
	vmovsd	-3312(%rbp), %xmm22
	vfnmadd231pd	%zmm9, %zmm28, %zmm18
	vmovsd	-8712(%rbp), %xmm28
	vmovq	%rcx, %xmm9
	vfmadd231sd	.LC1(%rip), %xmm31, %xmm9
	vfmadd231sd	%xmm24, %xmm7, %xmm6
	vfmadd231sd	%xmm14, %xmm10, %xmm6
	vfmadd132sd	%xmm28, %xmm30, %xmm22
	vmovsd	-3632(%rbp), %xmm30
	vfmadd231sd	%xmm3, %xmm7, %xmm9
	vmovsd	%xmm22, -3184(%rbp)
	vmovq	%rax, %xmm22
	vfmadd132sd	%xmm28, %xmm3, %xmm30
	vaddsd	-8704(%rbp), %xmm26, %xmm3
	vmovapd	-4208(%rbp), %zmm26
	vfmadd231sd	%xmm0, %xmm10, %xmm9
	vmovsd	%xmm30, -3312(%rbp)
	vmovsd	-3696(%rbp), %xmm30
	vfmadd132sd	%xmm28, %xmm9, %xmm22
	vmovq	%xmm22, %r9
	vfnmadd132sd	%xmm28, %xmm0, %xmm30
	vmovsd	%xmm30, -3632(%rbp)
	vmovq	%rdx, %xmm30
	vfmadd132sd	%xmm28, %xmm6, %xmm30
	vmovq	%xmm30, %rsi
	vmovsd	%xmm5, %xmm5, %xmm30
	vmovapd	-4976(%rbp), %zmm5
	vfmadd132sd	%xmm28, %xmm24, %xmm30
	vmovsd	%xmm30, -3696(%rbp)
	vfmadd132pd	%zmm5, %zmm16, %zmm26
	vmovapd	-7216(%rbp), %zmm16
	vfmadd132pd	%zmm5, %zmm2, %zmm12
	vmovsd	-3760(%rbp), %xmm2
	vfmadd132pd	%zmm5, %zmm18, %zmm1
	vfmadd132pd	%zmm5, %zmm23, %zmm13
	vmovapd	-5552(%rbp), %zmm18
	vfmadd132pd	%zmm16, %zmm1, %zmm25
	vmovapd	-4528(%rbp), %zmm1
	vfmadd132sd	%xmm28, %xmm14, %xmm2
	vfmadd132pd	%zmm16, %zmm26, %zmm27
	vmovapd	%zmm25, %zmm30
	vmovapd	%zmm27, %zmm6
	vmovsd	%xmm2, -4208(%rbp)
	vfnmadd132pd	%zmm1, %zmm15, %zmm4
	vfnmadd231pd	%zmm1, %zmm21, %zmm13
	vmovsd	-8720(%rbp), %xmm1
	vfnmadd231pd	%zmm5, %zmm29, %zmm4
	vaddsd	-2928(%rbp), %xmm1, %xmm2
	vmovsd	-4400(%rbp), %xmm5
	vaddsd	-2824(%rbp), %xmm1, %xmm0
	vaddpd	-8816(%rbp), %zmm18, %zmm29
	vaddsd	%xmm1, %xmm5, %xmm5
	vmovsd	-2336(%rbp), %xmm1
	vmovsd	%xmm2, -4784(%rbp)
	vmovsd	-2832(%rbp), %xmm2
	vmovsd	%xmm0, -4400(%rbp)
	vmovsd	-2352(%rbp), %xmm0
	vfmadd132sd	%xmm2, %xmm1, %xmm8
	vmovsd	-2840(%rbp), %xmm1
	vfnmadd132sd	%xmm1, %xmm8, %xmm11
	vmovsd	%xmm11, -2824(%rbp)
	vmovsd	.LC1(%rip), %xmm11
	vfmadd231sd	-3376(%rbp), %xmm11, %xmm0
	vfmadd132sd	%xmm2, %xmm0, %xmm7
	vmovsd	.LC10(%rip), %xmm2
	vfmadd132sd	%xmm1, %xmm7, %xmm10
	vandpd	.LC9(%rip), %xmm10, %xmm0
	vmovsd	%xmm10, -4272(%rbp)
	vcomisd	%xmm0, %xmm2
	jbe	.L172
	vmovsd	-4272(%rbp), %xmm2
	vmovsd	.LC24(%rip), %xmm7
	vmulsd	.LC11(%rip), %xmm2, %xmm9
	vmovsd	.LC18(%rip), %xmm8
	vmovsd	.LC22(%rip), %xmm14
	vmovsd	.LC16(%rip), %xmm18
	vmovsd	.LC20(%rip), %xmm10
	vmovsd	.LC14(%rip), %xmm15
	vrndscalesd	$4, %xmm9, %xmm9, %xmm9
	vfnmadd231sd	.LC12(%rip), %xmm9, %xmm2
	vcvttsd2sil	%xmm9, %eax
	vmovsd	%xmm2, %xmm2, %xmm1
	vfnmadd231sd	.LC13(%rip), %xmm9, %xmm1
	vmovsd	.LC4(%rip), %xmm2
	vmulsd	%xmm1, %xmm1, %xmm11
	vfnmadd213sd	.LC25(%rip), %xmm11, %xmm7
	vfmadd213sd	.LC19(%rip), %xmm11, %xmm8
	vfnmadd213sd	.LC23(%rip), %xmm11, %xmm14
	vfmadd213sd	.LC17(%rip), %xmm11, %xmm18
	vfnmadd213sd	.LC21(%rip), %xmm11, %xmm10
	vfmadd213sd	.LC15(%rip), %xmm11, %xmm15
	vmulsd	%xmm11, %xmm11, %xmm0
	vfmadd231sd	.LC27(%rip), %xmm0, %xmm7
	vfmadd231sd	.LC26(%rip), %xmm0, %xmm8
	vmulsd	%xmm11, %xmm1, %xmm16
	vfmadd132sd	%xmm0, %xmm14, %xmm7
	vfmadd132sd	%xmm0, %xmm18, %xmm8
	vfmadd132sd	%xmm0, %xmm10, %xmm7
	vfmadd132sd	%xmm0, %xmm15, %xmm8
	vmulsd	%xmm7, %xmm0, %xmm0
	vfmsub132sd	.LC28(%rip), %xmm0, %xmm11
	vfmadd132sd	%xmm8, %xmm1, %xmm16
	vsubsd	%xmm11, %xmm2, %xmm11
	testb	$1, %al
	jne	.L16
	vmovq	%xmm16, %rdx
	vmovsd	%xmm11, %xmm11, %xmm16
	vmovq	%rdx, %xmm11
.L16:
	testb	$2, %al
	je	.L17
	vxorpd	.LC29(%rip), %xmm11, %xmm11
.L17:
	incl	%eax
	testb	$2, %al
	je	.L15
	vxorpd	.LC29(%rip), %xmm16, %xmm16
.L15:
	vmovapd	-3568(%rbp), %zmm2
	vmovapd	-3056(%rbp), %zmm0
	vaddpd	-5680(%rbp), %zmm2, %zmm10
	vmovapd	-8880(%rbp), %zmm2
	vaddpd	-3120(%rbp), %zmm2, %zmm1
	vbroadcastsd	168(%rbx), %zmm27
	vbroadcastsd	176(%rbx), %zmm9
	vbroadcastsd	192(%rbx), %zmm7
	vaddpd	-3824(%rbp), %zmm12, %zmm12
	vaddpd	-3888(%rbp), %zmm10, %zmm10
	vmulpd	200(%rbx){1to8}, %zmm0, %zmm22
	vmulpd	%zmm0, %zmm27, %zmm8
	vmulpd	-2800(%rbp), %zmm27, %zmm27
	vmovapd	%zmm7, -7472(%rbp)
	vmovapd	%zmm1, -3568(%rbp)
	vaddpd	%zmm2, %zmm19, %zmm1
	vaddpd	%zmm2, %zmm20, %zmm2
	vmulpd	%zmm17, %zmm9, %zmm28
	vmulpd	-2480(%rbp), %zmm9, %zmm9
	vmovapd	%zmm1, -4848(%rbp)
	vmulpd	%zmm7, %zmm17, %zmm24
	vmovapd	%zmm2, -4912(%rbp)
	vbroadcastsd	184(%rbx), %zmm2
	vmulpd	%zmm0, %zmm2, %zmm23
	vmovapd	%zmm2, -7408(%rbp)
	vmovsd	-2824(%rbp), %xmm2
	vandpd	.LC9(%rip), %xmm2, %xmm0
	vmovsd	.LC10(%rip), %xmm2
	vcomisd	%xmm0, %xmm2
	jbe	.L173
	vmovsd	-2824(%rbp), %xmm2
	vmovsd	.LC24(%rip), %xmm14
	vmulsd	.LC11(%rip), %xmm2, %xmm18
	vmovsd	.LC18(%rip), %xmm15
	vmovsd	.LC22(%rip), %xmm20
	vmovsd	.LC16(%rip), %xmm26
	vmovsd	.LC20(%rip), %xmm19
	vmovsd	.LC14(%rip), %xmm25
	vrndscalesd	$4, %xmm18, %xmm18, %xmm18
	vfnmadd231sd	.LC12(%rip), %xmm18, %xmm2
	vcvttsd2sil	%xmm18, %eax
	vmovsd	%xmm2, %xmm2, %xmm7
	vfnmadd231sd	.LC13(%rip), %xmm18, %xmm7
	vmulsd	%xmm7, %xmm7, %xmm0
	vfnmadd213sd	.LC25(%rip), %xmm0, %xmm14
	vfmadd213sd	.LC19(%rip), %xmm0, %xmm15
	vfnmadd213sd	.LC23(%rip), %xmm0, %xmm20
	vfmadd213sd	.LC17(%rip), %xmm0, %xmm26
	vfnmadd213sd	.LC21(%rip), %xmm0, %xmm19
	vfmadd213sd	.LC15(%rip), %xmm0, %xmm25
	vmulsd	%xmm0, %xmm0, %xmm1
	vfmadd231sd	.LC27(%rip), %xmm1, %xmm14
	vfmadd231sd	.LC26(%rip), %xmm1, %xmm15
	vmulsd	%xmm7, %xmm0, %xmm21
	vmovsd	%xmm21, %xmm21, %xmm2
	vfmadd132sd	%xmm1, %xmm20, %xmm14
	vfmadd132sd	%xmm1, %xmm26, %xmm15
	vfmadd132sd	%xmm1, %xmm19, %xmm14
	vfmadd132sd	%xmm1, %xmm25, %xmm15
	vmulsd	%xmm14, %xmm1, %xmm1
	vfmsub132sd	.LC28(%rip), %xmm1, %xmm0
	vfmadd132sd	%xmm15, %xmm7, %xmm2
	vmovsd	.LC4(%rip), %xmm7
	vmovsd	%xmm2, -2336(%rbp)
	vsubsd	%xmm0, %xmm7, %xmm0
	testb	$1, %al
	jne	.L20
	vmovsd	%xmm0, -2336(%rbp)
	vmovsd	%xmm2, %xmm2, %xmm0
.L20:
	testb	$2, %al
	je	.L21
	vxorpd	.LC29(%rip), %xmm0, %xmm0
.L21:
	incl	%eax
	testb	$2, %al
	je	.L19
	vmovsd	-2336(%rbp), %xmm2
	vxorpd	.LC29(%rip), %xmm2, %xmm2
	vmovsd	%xmm2, -2336(%rbp)
.L19:
	vmovsd	-2336(%rbp), %xmm2
	vmulsd	%xmm0, %xmm11, %xmm7
	movq	%r13, %rax
	movq	%rdi, %rcx
	vmulsd	%xmm0, %xmm16, %xmm0
	vmovsd	%xmm7, -2352(%rbp)
	vmulsd	%xmm2, %xmm11, %xmm11
	vmulsd	%xmm2, %xmm16, %xmm2
	vunpcklpd	%xmm11, %xmm0, %xmm0
	vmovsd	%xmm2, -2928(%rbp)
	vmovupd	%xmm0, 256(%r12)
	vunpcklpd	%xmm2, %xmm7, %xmm0
	vmovq	%r13, %xmm2
	vucomisd	%xmm2, %xmm2
	vmovq	%rdi, %xmm2
	cmovp	%r14, %rax
	vmovupd	%xmm0, 624(%r12)
	vucomisd	%xmm2, %xmm2
	cmovp	%r14, %rcx
	vmovq	%r8, %xmm2
	movq	%rax, -4336(%rbp)
	movq	%rcx, -3440(%rbp)
	movq	%r8, %rcx
	vucomisd	%xmm2, %xmm2
	vmovq	%r13, %xmm2
	cmovp	%r14, %rcx
	vucomisd	%xmm2, %xmm2
	vmovq	%rcx, %xmm1
	jp	.L102
	vmovq	%rax, %xmm2
	vmulsd	%xmm2, %xmm2, %xmm0
.L25:
	vmovq	%rdi, %xmm2
	vucomisd	%xmm2, %xmm2
	jp	.L103
	vmovsd	-3440(%rbp), %xmm2
	vmulsd	%xmm2, %xmm2, %xmm26
.L26:
	vmovq	%r8, %xmm2
	vucomisd	%xmm2, %xmm2
	jp	.L104
	vmulsd	%xmm1, %xmm1, %xmm2
	vmovq	%xmm2, %rax
.L27:
	movq	.LC3(%rip), %rdx
	vmovq	%r13, %xmm2
	vaddpd	%zmm28, %zmm8, %zmm28
	vmovq	%rdi, %xmm8
	vucomisd	%xmm2, %xmm2
	vmovapd	-2800(%rbp), %zmm2
	vmovapd	-3056(%rbp), %zmm11
	vaddpd	%zmm9, %zmm27, %zmm27
	vmovsd	.LC4(%rip), %xmm9
	vmovapd	-2480(%rbp), %zmm15
	vaddpd	%zmm28, %zmm28, %zmm28
	movq	%rdx, %rcx
	vsubpd	%zmm24, %zmm27, %zmm27
	cmovp	%r14, %rcx
	vucomisd	%xmm8, %xmm8
	vmovq	%rax, %xmm8
	cmovp	%r14, %rdx
	vaddsd	%xmm8, %xmm0, %xmm0
	vaddsd	-2344(%rbp), %xmm5, %xmm8
	xorl	%eax, %eax
	movq	%rcx, 640(%r12)
	vbroadcastsd	224(%rbx), %zmm1
	vsubpd	%zmm23, %zmm27, %zmm27
	vmovsd	%xmm31, %xmm31, %xmm23
	vbroadcastsd	216(%rbx), %zmm7
	vbroadcastsd	208(%rbx), %zmm14
	vsubpd	%zmm28, %zmm6, %zmm28
	vaddsd	%xmm26, %xmm0, %xmm0
	vsubsd	.LC4(%rip), %xmm0, %xmm0
	vmulpd	200(%rbx){1to8}, %zmm2, %zmm16
	vaddpd	%zmm30, %zmm27, %zmm24
	vmovapd	-3952(%rbp), %zmm27
	vmovapd	%zmm28, -5296(%rbp)
	vandpd	.LC9(%rip), %xmm0, %xmm0
	vcomisd	.LC30(%rip), %xmm0
	vaddpd	%zmm16, %zmm29, %zmm29
	vmulpd	%zmm11, %zmm1, %zmm18
	vmulpd	%zmm17, %zmm1, %zmm21
	vmovsd	%xmm8, -3504(%rbp)
	vmulpd	%zmm11, %zmm7, %zmm20
	vmulpd	%zmm17, %zmm14, %zmm25
	vbroadcastsd	232(%rbx), %zmm11
	vsubpd	%zmm21, %zmm13, %zmm13
	movq	%rdx, 648(%r12)
	vmovsd	%xmm0, -5424(%rbp)
	seta	%al
	vxorpd	%xmm0, %xmm0, %xmm0
	vmulpd	%zmm15, %zmm14, %zmm14
	vsubpd	%zmm20, %zmm13, %zmm20
	vcvtusi2sdl	%eax, %xmm0, %xmm0
	vmulpd	%zmm2, %zmm7, %zmm7
	vmovsd	%xmm0, 752(%r12)
	vdivsd	%xmm8, %xmm9, %xmm0
	vmovsd	-2808(%rbp), %xmm13
	vsubpd	%zmm25, %zmm27, %zmm6
	vaddpd	%zmm14, %zmm29, %zmm14
	vmulpd	%zmm15, %zmm1, %zmm15
	vmulpd	%zmm2, %zmm1, %zmm1
	vmovsd	-3248(%rbp), %xmm2
	vaddpd	%zmm7, %zmm12, %zmm12
	vmovapd	%zmm14, -3824(%rbp)
	vmovsd	-2816(%rbp), %xmm14
	vmulpd	%zmm17, %zmm11, %zmm19
	vmulpd	-2480(%rbp), %zmm11, %zmm11
	vsubpd	%zmm22, %zmm6, %zmm27
	vaddpd	%zmm1, %zmm10, %zmm10
	vmovsd	%xmm3, %xmm3, %xmm22
	vsubpd	%zmm19, %zmm4, %zmm4
	vmovapd	%zmm27, -3760(%rbp)
	vaddpd	%zmm12, %zmm15, %zmm15
	vucomisd	%xmm2, %xmm2
	vmovsd	%xmm2, %xmm2, %xmm25
	vsubpd	%zmm18, %zmm4, %zmm19
	vmovq	%xmm0, %rax
	cmovp	%r14, %rax
	vmovq	%rax, %xmm0
	vmulsd	%xmm13, %xmm0, %xmm7
	vmulsd	%xmm5, %xmm0, %xmm8
	vaddpd	%zmm11, %zmm10, %zmm16
	vmulsd	%xmm3, %xmm0, %xmm9
	vmulsd	%xmm31, %xmm0, %xmm26
	vmovsd	%xmm8, 312(%r12)
	vmovsd	%xmm7, 320(%r12)
	vmulsd	%xmm14, %xmm0, %xmm0
	vfnmadd132sd	%xmm8, %xmm3, %xmm22
	vmovsd	%xmm26, 296(%r12)
	vmovsd	%xmm9, 304(%r12)
	vfnmadd132sd	%xmm8, %xmm31, %xmm23
	vmovsd	%xmm0, 328(%r12)
	vsubsd	-3376(%rbp), %xmm2, %xmm18
	vmovsd	-3184(%rbp), %xmm11
	vmovapd	-4016(%rbp), %zmm12
	vmovapd	-4080(%rbp), %zmm21
	vbroadcastsd	240(%rbx), %zmm1
	vbroadcastsd	248(%rbx), %zmm10
	vmovapd	-4592(%rbp), %zmm4
	vmovapd	-3056(%rbp), %zmm2
	vmovapd	-5040(%rbp), %zmm29
	vfnmadd231sd	%xmm26, %xmm31, %xmm11
	vmovq	%xmm18, %rax
	vfmadd231pd	136(%rbx){1to8}, %zmm12, %zmm4
	cmovp	%r14, %rax
	vmovq	%xmm11, %r13
	vmovq	%r9, %xmm11
	vfnmadd132pd	%zmm1, %zmm4, %zmm2
	vfnmadd231pd	144(%rbx){1to8}, %zmm21, %zmm2
	vfnmadd231sd	%xmm9, %xmm31, %xmm11
	vfnmadd231pd	%zmm17, %zmm10, %zmm2
	vmulpd	272(%rbx){1to8}, %zmm2, %zmm4
	vmovq	%rax, %xmm18
	xorl	%eax, %eax
	vmovapd	%zmm4, -3888(%rbp)
	vmovq	%xmm11, %r9
	vmovsd	-3312(%rbp), %xmm11
	vfnmadd231sd	%xmm7, %xmm31, %xmm11
	vfnmadd213sd	-3632(%rbp), %xmm0, %xmm31
	vmovsd	%xmm11, -2808(%rbp)
	vmovq	%rsi, %xmm11
	vfnmadd231sd	%xmm9, %xmm3, %xmm11
	vmovq	%xmm11, %rsi
	vmovsd	-3696(%rbp), %xmm11
	vmovsd	%xmm31, -4592(%rbp)
	vmovsd	%xmm5, %xmm5, %xmm31
	vfnmadd132sd	%xmm8, %xmm5, %xmm31
	vmovsd	%xmm31, -5360(%rbp)
	vfnmadd231sd	%xmm7, %xmm3, %xmm11
	vfnmadd213sd	-4208(%rbp), %xmm0, %xmm3
	vmovq	%xmm11, %rcx
	vmovsd	%xmm13, %xmm13, %xmm11
	vfnmadd231sd	%xmm7, %xmm5, %xmm11
	vfnmadd132sd	%xmm0, %xmm14, %xmm5
	vmovq	%xmm3, %rdi
	vmovsd	-4400(%rbp), %xmm3
	vfnmadd231sd	%xmm13, %xmm7, %xmm3
	vmovsd	%xmm3, -4400(%rbp)
	vmovapd	-4656(%rbp), %zmm3
	vfmadd231pd	.LC7(%rip), %zmm29, %zmm3
	vfmadd132pd	-2800(%rbp), %zmm3, %zmm1
	vfmadd231pd	152(%rbx){1to8}, %zmm12, %zmm1
	vfmadd132pd	-2480(%rbp), %zmm1, %zmm10
	vbroadcastsd	264(%rbx), %zmm1
	vfmadd231pd	160(%rbx){1to8}, %zmm21, %zmm10
	vmulpd	%zmm2, %zmm1, %zmm3
	vfmadd231pd	256(%rbx){1to8}, %zmm10, %zmm3
	vmovapd	%zmm3, -3632(%rbp)
	vmulpd	280(%rbx){1to8}, %zmm4, %zmm3
	vfmadd132pd	%zmm10, %zmm3, %zmm1
	vmovapd	%zmm1, -3696(%rbp)
	vmovsd	-2344(%rbp), %xmm6
	vmovapd	-3568(%rbp), %zmm4
	vaddpd	-4464(%rbp), %zmm4, %zmm28
	vmovq	%r14, %xmm4
	vucomisd	288(%rbx), %xmm4
	vfnmadd213sd	-4784(%rbp), %xmm0, %xmm14
	vfnmadd213sd	-2328(%rbp), %xmm0, %xmm13
	vbroadcastsd	320(%rbx), %zmm30
	vbroadcastsd	328(%rbx), %zmm17
	vmovsd	%xmm6, %xmm6, %xmm12
	vmovsd	%xmm6, %xmm6, %xmm21
	vmovsd	%xmm6, %xmm6, %xmm4
	vfnmadd132sd	%xmm26, %xmm23, %xmm12
	vfnmadd132sd	%xmm9, %xmm22, %xmm21
	setp	%al
	vfnmadd132sd	%xmm7, %xmm11, %xmm4
	cmovne	%r15, %rax
	vmovapd	%zmm30, -3184(%rbp)
	negq	%rax
	vmovapd	%zmm17, -3248(%rbp)
	vucomisd	%xmm25, %xmm25
	vmulsd	%xmm12, %xmm26, %xmm3
	vpbroadcastq	%rax, %zmm27
	vmovsd	%xmm14, -4656(%rbp)
	vbroadcastsd	304(%rbx), %zmm14
	vpandq	%zmm29, %zmm27, %zmm27
	vmovsd	%xmm6, %xmm6, %xmm29
	vfnmadd132sd	%xmm0, %xmm5, %xmm6
	vmovsd	%xmm13, -2328(%rbp)
	vmovsd	%xmm3, -4784(%rbp)
	vmulsd	%xmm12, %xmm9, %xmm3
	vfnmadd132sd	%xmm8, %xmm31, %xmm29
	vmovsd	%xmm3, -5808(%rbp)
	vmulsd	%xmm12, %xmm8, %xmm3
	vmovsd	%xmm6, %xmm6, %xmm31
	vmulpd	.LC31(%rip), %zmm28, %zmm6
	vmovapd	%zmm14, -3120(%rbp)
	vmulsd	%xmm29, %xmm8, %xmm1
	vmovq	%xmm3, %r8
	vmulsd	%xmm12, %xmm7, %xmm3
	vmulsd	%xmm12, %xmm0, %xmm12
	vmovsd	%xmm3, -5872(%rbp)
	vbroadcastsd	296(%rbx), %zmm3
	vmovapd	%zmm6, -7856(%rbp)
	vmovapd	%zmm3, %zmm13
	vmovapd	%zmm3, -3056(%rbp)
	vmovsd	312(%rbx), %xmm3
	vmovsd	%xmm3, -7752(%rbp)
	vmovapd	%zmm6, %zmm3
	vfnmadd213pd	-3760(%rbp), %zmm13, %zmm6
	vmovapd	%zmm6, -5744(%rbp)
	vmovapd	%zmm3, %zmm13
	vfnmadd213pd	-3824(%rbp), %zmm14, %zmm13
	vmovapd	%zmm13, -4208(%rbp)
	vmovapd	%zmm3, %zmm13
	vfnmadd213pd	-2416(%rbp), %zmm17, %zmm3
	vmovapd	%zmm3, -3952(%rbp)
	vmovapd	%zmm6, %zmm3
	vfnmadd213pd	-2672(%rbp), %zmm30, %zmm13
	vmovapd	%zmm13, -3312(%rbp)
	vmulpd	%zmm6, %zmm14, %zmm13
	vmulpd	%zmm30, %zmm6, %zmm6
	vmulpd	%zmm17, %zmm3, %zmm14
	vmulsd	%xmm21, %xmm9, %xmm3
	vmovapd	%zmm6, -5936(%rbp)
	vmovsd	%xmm3, -6000(%rbp)
	vmulsd	%xmm21, %xmm8, %xmm3
	vmovsd	%xmm1, -6128(%rbp)
	vmulsd	%xmm29, %xmm7, %xmm1
	vmovsd	%xmm3, -6064(%rbp)
	vmovsd	%xmm1, -6192(%rbp)
	vmulsd	%xmm29, %xmm0, %xmm1
	vmulsd	%xmm21, %xmm7, %xmm3
	vmulsd	%xmm21, %xmm0, %xmm21
	vmovsd	%xmm1, -6256(%rbp)
	vmulsd	%xmm4, %xmm7, %xmm1
	vmulsd	%xmm4, %xmm0, %xmm4
	vmovsd	%xmm1, -6320(%rbp)
	vmulsd	%xmm31, %xmm0, %xmm1
	vmovsd	%xmm1, -6384(%rbp)
	jp	.L107
	vmovsd	-3504(%rbp), %xmm6
	vmovq	%r14, %xmm1
	movl	$1, %eax
	vucomisd	%xmm1, %xmm6
	setp	%dl
	vxorpd	%xmm6, %xmm6, %xmm6
	cmove	%edx, %eax
	movzbl	%al, %eax
	vcvtusi2sdl	%eax, %xmm6, %xmm30
.L32:
	vmovapd	-3056(%rbp), %zmm6
	vmovapd	-3312(%rbp), %zmm17
	vmovapd	-4208(%rbp), %zmm29
	vmulpd	-3184(%rbp), %zmm29, %zmm31
	vmulpd	%zmm17, %zmm6, %zmm1
	vmulpd	%zmm29, %zmm6, %zmm25
	vmulpd	-3248(%rbp), %zmm29, %zmm29
	vmovapd	%zmm1, -6448(%rbp)
	vmulpd	-3120(%rbp), %zmm17, %zmm1
	vmulpd	-3248(%rbp), %zmm17, %zmm17
	vmovapd	%zmm1, -6512(%rbp)
	vmulpd	-3952(%rbp), %zmm6, %zmm1
	vmovapd	-3952(%rbp), %zmm6
	vmovapd	%zmm1, -6576(%rbp)
	vmulpd	-3120(%rbp), %zmm6, %zmm1
	vmovapd	%zmm1, -6640(%rbp)
	vmovsd	-2824(%rbp), %xmm1
	vfmadd231sd	%xmm26, %xmm18, %xmm1
	vmovsd	%xmm1, -2824(%rbp)
	vmovsd	-4272(%rbp), %xmm1
	vfmadd231sd	%xmm9, %xmm18, %xmm1
	vmovsd	%xmm1, -4272(%rbp)
	vmovsd	-3376(%rbp), %xmm1
	vfmadd231sd	%xmm8, %xmm18, %xmm1
	vmovsd	%xmm1, -3376(%rbp)
	vmovsd	-2832(%rbp), %xmm1
	vfmadd231sd	%xmm7, %xmm18, %xmm1
	vmovsd	%xmm1, -2816(%rbp)
	vmovsd	-2840(%rbp), %xmm1
	vfmadd231sd	%xmm0, %xmm18, %xmm1
	vmovsd	%xmm1, -2832(%rbp)
	vmovq	%r13, %xmm1
	vsubsd	-4784(%rbp), %xmm1, %xmm1
	vmovq	%xmm1, %r13
	vmovq	%r9, %xmm1
	vsubsd	-5808(%rbp), %xmm1, %xmm1
	vmovq	%xmm1, %r9
	vmovq	%r8, %xmm1
	vsubsd	%xmm1, %xmm23, %xmm1
	vmovsd	-4592(%rbp), %xmm23
	vmovq	%xmm1, %r8
	vmovsd	-2808(%rbp), %xmm1
	vsubsd	-5872(%rbp), %xmm1, %xmm1
	vsubsd	%xmm12, %xmm23, %xmm12
	vmovsd	%xmm12, -2808(%rbp)
	vmovq	%rsi, %xmm12
	vsubsd	-6000(%rbp), %xmm12, %xmm12
	vmovq	%xmm12, %rdx
	vsubsd	-6064(%rbp), %xmm22, %xmm12
	vmovq	%xmm12, %rax
	vmovq	%rcx, %xmm12
	vsubsd	%xmm3, %xmm12, %xmm3
	vmovq	%rdi, %xmm12
	vsubsd	%xmm21, %xmm12, %xmm12
	vmovq	%xmm12, %rdi
	vmovsd	-5360(%rbp), %xmm12
	vmovsd	344(%rbx), %xmm22
	vfmadd132pd	376(%rbx){1to8}, %zmm27, %zmm28
	vmovapd	-3312(%rbp), %zmm23
	vmovapd	%zmm28, -5808(%rbp)
	vmulpd	-3184(%rbp), %zmm6, %zmm21
	vsubsd	-6128(%rbp), %xmm12, %xmm12
	vmulpd	-3184(%rbp), %zmm28, %zmm27
	vsubsd	-6192(%rbp), %xmm11, %xmm11
	vmulpd	-3248(%rbp), %zmm28, %zmm28
	vmovsd	%xmm22, -7760(%rbp)
	vmovsd	352(%rbx), %xmm22
	vmovq	%xmm12, %rsi
	vmovapd	-5744(%rbp), %zmm12
	vmovsd	%xmm22, -7768(%rbp)
	vmulpd	360(%rbx){1to8}, %zmm23, %zmm22
	vmulpd	368(%rbx){1to8}, %zmm6, %zmm23
	vmovapd	-5808(%rbp), %zmm6
	vfnmadd231pd	-3056(%rbp), %zmm6, %zmm2
	vfnmadd231pd	-3120(%rbp), %zmm6, %zmm10
	vsubsd	-6256(%rbp), %xmm5, %xmm6
	vmulpd	336(%rbx){1to8}, %zmm12, %zmm12
	vmovsd	%xmm30, 288(%r12)
	vmovq	%r14, %xmm30
	vmovq	%xmm6, %rcx
	vmovsd	-4400(%rbp), %xmm6
	vsubsd	-6320(%rbp), %xmm6, %xmm5
	vmovsd	-2328(%rbp), %xmm6
	vsubsd	%xmm4, %xmm6, %xmm4
	vmovsd	-4656(%rbp), %xmm6
	vsubsd	-6384(%rbp), %xmm6, %xmm6
	vmovsd	%xmm6, -2840(%rbp)
	vmovsd	-3504(%rbp), %xmm6
	vucomisd	%xmm30, %xmm6
	jp	.L33
	vxorpd	%xmm30, %xmm30, %xmm30
	je	.L97
.L33:
	vmovsd	.LC4(%rip), %xmm6
	vdivsd	-3504(%rbp), %xmm6, %xmm30
.L97:
	vmovapd	-4016(%rbp), %zmm6
	vmulsd	%xmm30, %xmm18, %xmm30
	vaddsd	%xmm0, %xmm0, %xmm0
	vaddsd	%xmm26, %xmm26, %xmm26
	vaddsd	%xmm7, %xmm7, %xmm7
	vaddsd	%xmm9, %xmm9, %xmm9
	vunpcklpd	%xmm30, %xmm0, %xmm0
	vaddsd	%xmm8, %xmm8, %xmm8
	vmovsd	%xmm26, 336(%r12)
	vmovupd	%xmm0, 368(%r12)
	vmovsd	%xmm7, 360(%r12)
	vsubpd	%zmm13, %zmm24, %zmm13
	vmovsd	%xmm9, 344(%r12)
	vmovsd	%xmm8, 352(%r12)
	vbroadcastsd	376(%rbx), %zmm7
	vsubpd	%zmm27, %zmm6, %zmm27
	vmovapd	-4080(%rbp), %zmm6
	vfmadd231pd	-2672(%rbp), %zmm7, %zmm27
	vmovapd	%zmm27, -5872(%rbp)
	vmovapd	%zmm7, %zmm26
	vfmadd132pd	-3760(%rbp), %zmm2, %zmm26
	vmovapd	%zmm7, %zmm2
	vmovapd	%zmm7, %zmm30
	vsubpd	%zmm28, %zmm6, %zmm28
	vmovapd	-5296(%rbp), %zmm6
	vfmadd132pd	-2416(%rbp), %zmm28, %zmm2
	vmovapd	%zmm2, %zmm27
	vmovsd	.LC4(%rip), %xmm2
	vmovapd	%zmm7, -7536(%rbp)
	vfmadd132pd	-3824(%rbp), %zmm10, %zmm30
	vsubpd	%zmm12, %zmm6, %zmm18
	vaddsd	-2344(%rbp), %xmm5, %xmm6
	vdivsd	%xmm6, %xmm2, %xmm0
	vmovsd	-2544(%rbp), %xmm2
	vmovsd	%xmm6, -2328(%rbp)
	vucomisd	%xmm2, %xmm2
	jp	.L183
	vmulsd	%xmm0, %xmm1, %xmm10
	vmulsd	%xmm0, %xmm3, %xmm9
	vmovsd	-2544(%rbp), %xmm2
	vaddsd	-2816(%rbp), %xmm2, %xmm12
	vmulsd	%xmm0, %xmm11, %xmm8
	vmulsd	%xmm0, %xmm5, %xmm7
	vmulsd	%xmm0, %xmm4, %xmm0
.L96:
	vsubpd	%zmm31, %zmm15, %zmm15
	vsubpd	-6512(%rbp), %zmm15, %zmm2
	vmovq	%r13, %xmm15
	vmovsd	%xmm1, %xmm1, %xmm24
	vfnmadd231sd	%xmm10, %xmm1, %xmm15
	vsubpd	%zmm25, %zmm13, %zmm6
	vmovapd	-2992(%rbp), %zmm13
	vfnmadd132sd	%xmm7, %xmm1, %xmm24
	vmovsd	%xmm10, 392(%r12)
	vmovsd	%xmm9, 400(%r12)
	vmovsd	%xmm8, 408(%r12)
	vmovsd	%xmm7, 416(%r12)
	vmovsd	%xmm0, 424(%r12)
	vsubpd	%zmm14, %zmm19, %zmm14
	vmovapd	%zmm6, -3504(%rbp)
	vsubpd	%zmm29, %zmm16, %zmm16
	vmovsd	%xmm3, %xmm3, %xmm29
	vmovq	%xmm15, %r13
	vsubpd	-5936(%rbp), %zmm20, %zmm6
	vmovq	%r9, %xmm15
	vmovsd	%xmm11, %xmm11, %xmm20
	vfnmadd231sd	%xmm9, %xmm1, %xmm15
	vsubpd	-6576(%rbp), %zmm14, %zmm28
	vbroadcastsd	392(%rbx), %zmm14
	vfnmadd132sd	%xmm7, %xmm3, %xmm29
	vsubpd	-6640(%rbp), %zmm16, %zmm31
	vfnmadd132sd	%xmm7, %xmm11, %xmm20
	vsubpd	-6448(%rbp), %zmm6, %zmm6
	vsubpd	%zmm17, %zmm13, %zmm17
	vmovapd	-4912(%rbp), %zmm13
	vmovsd	%xmm15, -4400(%rbp)
	vmovq	%r8, %xmm15
	vmovapd	%zmm2, -4080(%rbp)
	vfnmadd231sd	%xmm8, %xmm1, %xmm15
	vfnmadd213sd	-2808(%rbp), %xmm0, %xmm1
	vsubpd	%zmm21, %zmm17, %zmm21
	vmovapd	%zmm14, -5296(%rbp)
	vmovapd	%zmm21, -5936(%rbp)
	vmovq	%xmm15, %r9
	vsubpd	%zmm23, %zmm13, %zmm23
	vbroadcastsd	400(%rbx), %zmm13
	vmovapd	%zmm6, -4016(%rbp)
	vmovsd	%xmm1, -4592(%rbp)
	vmovq	%rdx, %xmm1
	vfnmadd231sd	%xmm9, %xmm3, %xmm1
	vmovsd	%xmm1, -4656(%rbp)
	vmovq	%rax, %xmm1
	xorl	%eax, %eax
	vfnmadd231sd	%xmm8, %xmm3, %xmm1
	vmovsd	%xmm1, -4784(%rbp)
	vmovapd	-4848(%rbp), %zmm1
	vsubpd	%zmm22, %zmm1, %zmm1
	vaddpd	-4464(%rbp), %zmm1, %zmm25
	vmovapd	%zmm1, -4848(%rbp)
	vmovq	%r14, %xmm1
	vucomisd	384(%rbx), %xmm1
	vmulpd	.LC31(%rip), %zmm25, %zmm22
	vmovsd	408(%rbx), %xmm1
	setp	%al
	cmovne	%r15, %rax
	negq	%rax
	vmovapd	%zmm22, -7920(%rbp)
	vmovapd	%zmm22, %zmm19
	vpbroadcastq	%rax, %zmm6
	vpandq	-5872(%rbp), %zmm6, %zmm6
	vmovsd	%xmm1, -7776(%rbp)
	vfnmadd213pd	-4016(%rbp), %zmm14, %zmm19
	vmovsd	416(%rbx), %xmm1
	vmovapd	%zmm13, -2992(%rbp)
	vmovapd	%zmm19, -7984(%rbp)
	vbroadcastsd	424(%rbx), %zmm17
	vmovsd	%xmm1, -7784(%rbp)
	vmovq	%rdi, %xmm1
	vfnmadd231sd	%xmm0, %xmm3, %xmm1
	vmovq	%rsi, %xmm3
	vfnmadd231sd	%xmm8, %xmm11, %xmm3
	vmulpd	%zmm17, %zmm19, %zmm16
	vmovapd	%zmm17, -5360(%rbp)
	vmovsd	%xmm1, -4912(%rbp)
	vmovsd	%xmm3, -6128(%rbp)
	vmovq	%rcx, %xmm3
	vfnmadd231sd	%xmm0, %xmm11, %xmm3
	vmovapd	%zmm14, %zmm11
	vmulpd	%zmm19, %zmm13, %zmm14
	vmulpd	432(%rbx){1to8}, %zmm19, %zmm19
	vmovsd	%xmm3, -6192(%rbp)
	vmovsd	%xmm5, %xmm5, %xmm3
	vfnmadd132sd	%xmm7, %xmm5, %xmm3
	vfnmadd132sd	%xmm0, %xmm4, %xmm5
	vfnmadd213sd	-2840(%rbp), %xmm0, %xmm4
	vmovsd	%xmm3, -2808(%rbp)
	vmovsd	-2344(%rbp), %xmm3
	vmovsd	%xmm4, -2840(%rbp)
	vmovapd	%zmm22, %zmm4
	vfnmadd132pd	%zmm17, %zmm21, %zmm22
	vfnmadd213pd	-4080(%rbp), %zmm13, %zmm4
	vmovsd	%xmm3, %xmm3, %xmm1
	vmulpd	%zmm11, %zmm4, %zmm21
	vmovapd	%zmm11, %zmm13
	vmovsd	%xmm3, %xmm3, %xmm2
	vfnmadd132sd	%xmm10, %xmm24, %xmm1
	vmovsd	%xmm3, %xmm3, %xmm15
	vmovapd	%zmm4, -6640(%rbp)
	vfnmadd132sd	%xmm9, %xmm29, %xmm2
	vmovapd	%zmm22, -6000(%rbp)
	vmulpd	%zmm17, %zmm4, %zmm17
	vfnmadd132sd	%xmm8, %xmm20, %xmm15
	vmovsd	%xmm3, %xmm3, %xmm4
	vfnmadd213sd	-2808(%rbp), %xmm7, %xmm3
	vmulsd	%xmm10, %xmm1, %xmm11
	vfnmadd132sd	%xmm0, %xmm5, %xmm4
	vmovsd	%xmm11, -6064(%rbp)
	vmulsd	%xmm9, %xmm1, %xmm11
	vmulsd	%xmm0, %xmm4, %xmm4
	vmovq	%xmm11, %r8
	vmulsd	%xmm8, %xmm1, %xmm11
	vmovsd	%xmm11, -6256(%rbp)
	vmulsd	%xmm7, %xmm1, %xmm11
	vmulsd	%xmm0, %xmm1, %xmm1
	vmovsd	%xmm1, -6320(%rbp)
	vmulsd	%xmm9, %xmm2, %xmm1
	vmovq	%xmm1, %rdi
	vmulsd	%xmm8, %xmm2, %xmm1
	vmovq	%xmm1, %rsi
	vmulsd	%xmm7, %xmm2, %xmm1
	vmulsd	%xmm0, %xmm2, %xmm2
	vmovq	%xmm1, %rcx
	vmulsd	%xmm8, %xmm15, %xmm1
	vmovsd	%xmm1, -6384(%rbp)
	vmulsd	%xmm7, %xmm15, %xmm1
	vmulsd	%xmm0, %xmm15, %xmm15
	vmovsd	%xmm1, -6448(%rbp)
	vmulsd	%xmm7, %xmm3, %xmm1
	vmulsd	%xmm0, %xmm3, %xmm3
	vmovsd	%xmm1, -6512(%rbp)
	vmovapd	%zmm22, %zmm1
	vmulpd	-2992(%rbp), %zmm1, %zmm1
	vmulpd	%zmm22, %zmm13, %zmm22
	vmovapd	%zmm1, -6576(%rbp)
	vmovsd	440(%rbx), %xmm1
	vmovsd	%xmm1, -7792(%rbp)
	vmovsd	448(%rbx), %xmm1
	vmovsd	%xmm1, -7992(%rbp)
	vmovsd	456(%rbx), %xmm1
	vmovsd	%xmm1, -8000(%rbp)
	vmovsd	-2544(%rbp), %xmm1
	vucomisd	%xmm1, %xmm1
	jp	.L108
	vmovsd	-2328(%rbp), %xmm1
	vmovq	%r14, %xmm13
	movl	$1, %eax
	vucomisd	%xmm13, %xmm1
	setp	%dl
	vxorpd	%xmm1, %xmm1, %xmm1
	cmove	%edx, %eax
	movzbl	%al, %eax
	vcvtusi2sdl	%eax, %xmm1, %xmm1
	vmovq	%xmm1, %rax
.L37:
	vmovsd	-2824(%rbp), %xmm1
	vmovq	%r8, %xmm13
	vsubsd	%xmm3, %xmm5, %xmm3
	vfnmadd231sd	%xmm10, %xmm12, %xmm1
	vmovsd	%xmm1, -2824(%rbp)
	vmovsd	-4272(%rbp), %xmm1
	vfnmadd231sd	%xmm9, %xmm12, %xmm1
	vmovsd	%xmm1, -6832(%rbp)
	vmovsd	-3376(%rbp), %xmm1
	vfnmadd231sd	%xmm8, %xmm12, %xmm1
	vmovsd	%xmm1, -3376(%rbp)
	vmovsd	-2816(%rbp), %xmm1
	vfnmadd231sd	%xmm7, %xmm12, %xmm1
	vmovsd	%xmm1, -2816(%rbp)
	vmovsd	-2832(%rbp), %xmm1
	vfnmadd231sd	%xmm0, %xmm12, %xmm1
	vmovsd	%xmm1, -2544(%rbp)
	vmovq	%r13, %xmm1
	vsubsd	-6064(%rbp), %xmm1, %xmm1
	vmovq	%xmm1, %rdx
	vmovsd	-4400(%rbp), %xmm1
	vsubsd	%xmm13, %xmm1, %xmm1
	vmovsd	-4656(%rbp), %xmm13
	vmovq	%xmm1, %r8
	vmovq	%r9, %xmm1
	vsubsd	-6256(%rbp), %xmm1, %xmm1
	vmovq	%xmm1, %r9
	vsubsd	%xmm11, %xmm24, %xmm1
	vbroadcastsd	472(%rbx), %zmm11
	vmovq	%xmm1, %r13
	vmovapd	-6000(%rbp), %zmm1
	vfmsub132pd	%zmm11, %zmm6, %zmm25
	vmovapd	%zmm25, %zmm6
	vfmadd231pd	-5360(%rbp), %zmm6, %zmm27
	vmovapd	%zmm27, -6064(%rbp)
	vmovq	%rdi, %xmm27
	vmovapd	%zmm25, -6704(%rbp)
	vmovapd	-5296(%rbp), %zmm25
	vsubsd	%xmm27, %xmm13, %xmm13
	vmovq	%rsi, %xmm27
	vmulpd	464(%rbx){1to8}, %zmm1, %zmm24
	vmovsd	-4592(%rbp), %xmm1
	vsubsd	-6320(%rbp), %xmm1, %xmm1
	vmovq	%xmm13, %rdi
	vmovsd	-4784(%rbp), %xmm13
	vfmadd132pd	%zmm6, %zmm26, %zmm25
	vmovapd	-2992(%rbp), %zmm26
	vsubsd	%xmm27, %xmm13, %xmm13
	vmovq	%xmm13, %rsi
	vmovq	%rcx, %xmm13
	vsubsd	%xmm13, %xmm29, %xmm13
	vfmadd132pd	%zmm6, %zmm30, %zmm26
	vsubsd	-6448(%rbp), %xmm20, %xmm29
	vmulpd	-4016(%rbp), %zmm11, %zmm6
	vmulpd	-4080(%rbp), %zmm11, %zmm11
	vmovq	%xmm13, %rcx
	vmovsd	-4912(%rbp), %xmm13
	vsubsd	%xmm2, %xmm13, %xmm2
	vmovsd	-6128(%rbp), %xmm13
	vsubsd	-6384(%rbp), %xmm13, %xmm13
	vmovsd	%xmm13, -2832(%rbp)
	vmovsd	-6192(%rbp), %xmm13
	vmovsd	-2840(%rbp), %xmm5
	movq	%rax, 384(%r12)
	vsubsd	%xmm4, %xmm5, %xmm4
	vmovsd	-2328(%rbp), %xmm5
	vsubsd	%xmm15, %xmm13, %xmm15
	vmovsd	-2808(%rbp), %xmm13
	vsubsd	-6512(%rbp), %xmm13, %xmm27
	vmovq	%r14, %xmm13
	vucomisd	%xmm13, %xmm5
	jp	.L38
	vxorpd	%xmm5, %xmm5, %xmm5
	je	.L95
.L38:
	vmovsd	.LC4(%rip), %xmm5
	vdivsd	-2328(%rbp), %xmm5, %xmm5
.L95:
	vaddsd	%xmm10, %xmm10, %xmm10
	vsubpd	%zmm6, %zmm25, %zmm6
	vaddsd	-2344(%rbp), %xmm4, %xmm25
	vmovsd	%xmm10, 432(%r12)
	vbroadcastsd	472(%rbx), %zmm13
	vsubpd	%zmm11, %zmm26, %zmm11
	vmulpd	-5936(%rbp), %zmm13, %zmm10
	vsubpd	%zmm19, %zmm18, %zmm18
	vaddsd	%xmm9, %xmm9, %xmm9
	vaddsd	%xmm8, %xmm8, %xmm8
	vaddsd	%xmm7, %xmm7, %xmm7
	vaddsd	%xmm0, %xmm0, %xmm0
	vmovapd	%zmm13, -6384(%rbp)
	vmovapd	%zmm10, -6128(%rbp)
	vmovapd	-3504(%rbp), %zmm10
	vsubpd	%zmm14, %zmm10, %zmm14
	vmovsd	-2608(%rbp), %xmm10
	vsubpd	%zmm21, %zmm14, %zmm14
	vmulsd	%xmm5, %xmm12, %xmm21
	vmovsd	.LC4(%rip), %xmm5
	vucomisd	%xmm10, %xmm10
	vdivsd	%xmm25, %xmm5, %xmm5
	jp	.L184
	vmulsd	%xmm5, %xmm1, %xmm19
	vmulsd	%xmm5, %xmm2, %xmm13
	vmovsd	-2608(%rbp), %xmm20
	vaddsd	-2544(%rbp), %xmm20, %xmm20
	vmulsd	%xmm5, %xmm15, %xmm12
	vmulsd	%xmm5, %xmm3, %xmm10
	vmulsd	%xmm5, %xmm4, %xmm5
.L94:
	vmovsd	%xmm9, 440(%r12)
	vmovsd	%xmm7, 456(%r12)
	xorl	%eax, %eax
	vmovsd	%xmm21, 472(%r12)
	vmovsd	%xmm8, 448(%r12)
	vmovsd	%xmm0, 464(%r12)
	vmovsd	%xmm19, 488(%r12)
	vmovsd	%xmm13, 496(%r12)
	vmovsd	%xmm12, 504(%r12)
	vmovsd	%xmm10, 512(%r12)
	vmovsd	%xmm5, 520(%r12)
	vmovq	%rdx, %xmm7
	vsubpd	%zmm16, %zmm28, %zmm16
	vmovq	%r13, %xmm30
	vmovsd	504(%rbx), %xmm0
	vfnmadd231sd	%xmm19, %xmm1, %xmm7
	vbroadcastsd	488(%rbx), %zmm28
	vsubpd	%zmm17, %zmm31, %zmm17
	vbroadcastsd	496(%rbx), %zmm8
	vsubpd	%zmm22, %zmm16, %zmm9
	vsubpd	-6576(%rbp), %zmm17, %zmm16
	vfnmadd231sd	%xmm10, %xmm1, %xmm30
	vfnmadd132sd	%xmm5, %xmm4, %xmm4
	vfnmadd231sd	%xmm10, %xmm15, %xmm29
	vmovsd	%xmm7, -2328(%rbp)
	vsubpd	%zmm24, %zmm23, %zmm7
	vaddpd	-4464(%rbp), %zmm7, %zmm23
	vfnmadd231sd	%xmm10, %xmm3, %xmm27
	vmovapd	%zmm9, -6192(%rbp)
	vfnmadd132sd	%xmm5, %xmm3, %xmm3
	vmovapd	%zmm7, -4912(%rbp)
	vmovq	%r14, %xmm7
	vucomisd	480(%rbx), %xmm7
	vmulpd	.LC31(%rip), %zmm23, %zmm7
	vmovsd	%xmm0, -8008(%rbp)
	vmovsd	512(%rbx), %xmm0
	vmovapd	%zmm8, -7600(%rbp)
	vmovapd	%zmm16, -6256(%rbp)
	setp	%al
	vmovsd	%xmm0, -8016(%rbp)
	vmovsd	520(%rbx), %xmm0
	cmovne	%r15, %rax
	vmovapd	%zmm7, -8112(%rbp)
	negq	%rax
	vmovsd	%xmm0, -8024(%rbp)
	vmovapd	%zmm7, %zmm0
	vfnmadd132pd	%zmm28, %zmm9, %zmm7
	vmovq	%r8, %xmm9
	vfnmadd231sd	%xmm13, %xmm1, %xmm9
	vfnmadd132pd	%zmm8, %zmm16, %zmm0
	vmovapd	%zmm7, -8176(%rbp)
	vmovapd	%zmm0, -6768(%rbp)
	vmulpd	%zmm7, %zmm8, %zmm22
	vmulpd	%zmm0, %zmm28, %zmm24
	vmovapd	%zmm7, %zmm31
	vmovq	%xmm9, %r8
	vmovq	%r9, %xmm9
	vmovq	%xmm29, %r9
	vfnmadd231sd	%xmm12, %xmm1, %xmm9
	vfnmadd132sd	%xmm5, %xmm1, %xmm1
	vmovsd	%xmm9, -2840(%rbp)
	vmovq	%rdi, %xmm9
	vmovq	%xmm27, %rdi
	vfnmadd231sd	%xmm13, %xmm2, %xmm9
	vmovq	%xmm9, %r13
	vmovq	%rsi, %xmm9
	vfnmadd231sd	%xmm12, %xmm2, %xmm9
	vmovsd	%xmm9, -3504(%rbp)
	vmovq	%rcx, %xmm9
	vfnmadd231sd	%xmm10, %xmm2, %xmm9
	vfnmadd132sd	%xmm5, %xmm2, %xmm2
	vmovq	%xmm9, %rcx
	vmovsd	-2832(%rbp), %xmm9
	vmulpd	528(%rbx){1to8}, %zmm31, %zmm26
	vmovsd	-2344(%rbp), %xmm7
	vfnmadd231sd	%xmm12, %xmm15, %xmm9
	vmovsd	%xmm7, %xmm7, %xmm0
	vmovsd	%xmm7, %xmm7, %xmm8
	vmovsd	%xmm7, %xmm7, %xmm16
	vfnmadd132sd	%xmm19, %xmm1, %xmm0
	vfnmadd132sd	%xmm13, %xmm2, %xmm8
	vfnmadd132sd	%xmm5, %xmm15, %xmm15
	vfnmadd132sd	%xmm10, %xmm3, %xmm16
	vmovq	%xmm9, %rsi
	vmovsd	%xmm7, %xmm7, %xmm9
	vfnmadd132sd	%xmm5, %xmm4, %xmm7
	vmulsd	%xmm12, %xmm8, %xmm29
	vfnmadd132sd	%xmm12, %xmm15, %xmm9
	vmovsd	%xmm7, %xmm7, %xmm17
	vmulsd	%xmm19, %xmm0, %xmm7
	vmulsd	%xmm12, %xmm9, %xmm27
	vmulsd	%xmm5, %xmm17, %xmm17
	vmovsd	%xmm7, -2808(%rbp)
	vmulsd	%xmm13, %xmm0, %xmm7
	vmovsd	%xmm27, -6448(%rbp)
	vmulsd	%xmm10, %xmm9, %xmm27
	vmulsd	%xmm5, %xmm9, %xmm9
	vmovsd	%xmm7, -2832(%rbp)
	vmulsd	%xmm12, %xmm0, %xmm7
	vmovsd	%xmm27, -6512(%rbp)
	vmulsd	%xmm10, %xmm16, %xmm27
	vmulsd	%xmm5, %xmm16, %xmm16
	vmovsd	%xmm7, -4400(%rbp)
	vmulsd	%xmm10, %xmm0, %xmm7
	vmovsd	%xmm27, -6576(%rbp)
	vmovsd	-2608(%rbp), %xmm27
	vmulsd	%xmm5, %xmm0, %xmm0
	vmovsd	%xmm7, -4592(%rbp)
	vmulsd	%xmm13, %xmm8, %xmm7
	vmovsd	%xmm7, -4656(%rbp)
	vmulsd	%xmm10, %xmm8, %xmm7
	vucomisd	%xmm27, %xmm27
	vmulsd	%xmm5, %xmm8, %xmm8
	vmovsd	%xmm7, -6320(%rbp)
	vmovsd	536(%rbx), %xmm7
	vmovsd	%xmm7, -8032(%rbp)
	vmovsd	544(%rbx), %xmm7
	vmovsd	%xmm7, -8040(%rbp)
	vmovsd	552(%rbx), %xmm7
	vmovsd	%xmm7, -8048(%rbp)
	vmovsd	560(%rbx), %xmm7
	vmovsd	%xmm7, -8184(%rbp)
	vmovapd	-6128(%rbp), %zmm7
	vsubpd	-6064(%rbp), %zmm7, %zmm21
	vpbroadcastq	%rax, %zmm7
	vpandq	%zmm21, %zmm7, %zmm21
	vfmadd132pd	568(%rbx){1to8}, %zmm21, %zmm23
	vmulpd	%zmm23, %zmm28, %zmm7
	vmovapd	%zmm23, -4272(%rbp)
	jp	.L109
	vmovq	%r14, %xmm27
	movl	$1, %eax
	vucomisd	%xmm27, %xmm25
	setp	%dl
	vxorpd	%xmm27, %xmm27, %xmm27
	cmove	%edx, %eax
	movzbl	%al, %eax
	vcvtusi2sdl	%eax, %xmm27, %xmm21
.L42:
	vmovsd	-2824(%rbp), %xmm31
	vmovsd	-6832(%rbp), %xmm23
	vaddpd	%zmm7, %zmm6, %zmm7
	vsubsd	%xmm8, %xmm2, %xmm2
	vmovsd	-3376(%rbp), %xmm27
	vmovapd	-4272(%rbp), %zmm6
	vsubsd	%xmm16, %xmm3, %xmm3
	vsubpd	%zmm22, %zmm14, %zmm22
	vsubpd	%zmm24, %zmm22, %zmm24
	vfnmadd231sd	%xmm19, %xmm20, %xmm31
	vfnmadd231sd	%xmm13, %xmm20, %xmm23
	vfnmadd231sd	%xmm12, %xmm20, %xmm27
	vmovsd	%xmm31, 760(%r12)
	vmovsd	%xmm23, 768(%r12)
	vmovsd	%xmm27, -6840(%rbp)
	vfmadd231pd	496(%rbx){1to8}, %zmm6, %zmm11
	vmovsd	504(%rbx), %xmm27
	vbroadcastsd	568(%rbx), %zmm6
	vmovsd	%xmm27, -8192(%rbp)
	vmovsd	512(%rbx), %xmm27
	vmovapd	%zmm6, -4784(%rbp)
	vmovsd	%xmm27, -8200(%rbp)
	vmovsd	520(%rbx), %xmm27
	vmovsd	%xmm27, -8208(%rbp)
	vmovapd	%zmm6, %zmm27
	vfnmadd132pd	-6192(%rbp), %zmm7, %zmm27
	vmovsd	-2816(%rbp), %xmm7
	vfnmadd231sd	%xmm10, %xmm20, %xmm7
	vmovsd	%xmm7, -6848(%rbp)
	vmovsd	-2544(%rbp), %xmm7
	vfnmadd231sd	%xmm5, %xmm20, %xmm7
	vmovsd	%xmm7, -6856(%rbp)
	vmovsd	-2328(%rbp), %xmm7
	vsubsd	-2808(%rbp), %xmm7, %xmm7
	vmovsd	%xmm7, -2608(%rbp)
	vmovsd	%xmm7, 776(%r12)
	vmovq	%r8, %xmm7
	vsubsd	-2832(%rbp), %xmm7, %xmm7
	vmovsd	%xmm7, -2808(%rbp)
	vmovsd	%xmm7, 784(%r12)
	vmovsd	-2840(%rbp), %xmm7
	vsubsd	-4400(%rbp), %xmm7, %xmm7
	vmovsd	%xmm7, -2816(%rbp)
	vmovsd	%xmm7, 792(%r12)
	vsubsd	-4592(%rbp), %xmm30, %xmm30
	vmovsd	%xmm2, -2832(%rbp)
	vmovq	%rsi, %xmm2
	vsubsd	%xmm0, %xmm1, %xmm7
	vmovq	%r13, %xmm0
	vfnmadd231pd	-6256(%rbp), %zmm6, %zmm11
	vsubsd	-6448(%rbp), %xmm2, %xmm2
	vmovapd	%zmm11, -2544(%rbp)
	vmovsd	%xmm21, 480(%r12)
	vmovsd	%xmm7, -2824(%rbp)
	vmovsd	%xmm7, 808(%r12)
	vsubsd	-4656(%rbp), %xmm0, %xmm7
	vmovsd	-3504(%rbp), %xmm0
	vmovsd	%xmm3, -3504(%rbp)
	vsubpd	%zmm26, %zmm18, %zmm3
	vsubsd	%xmm17, %xmm4, %xmm26
	vmovq	%r14, %xmm4
	vucomisd	%xmm4, %xmm25
	vmovapd	%zmm3, -3376(%rbp)
	vmovsd	%xmm30, 800(%r12)
	vmovq	%xmm2, %rsi
	vmovq	%r9, %xmm2
	vsubsd	-6512(%rbp), %xmm2, %xmm2
	vsubsd	%xmm29, %xmm0, %xmm29
	vmovq	%rcx, %xmm0
	vmovq	%xmm7, %r13
	vsubsd	-6320(%rbp), %xmm0, %xmm7
	vmovq	%xmm2, %r9
	vsubsd	%xmm9, %xmm15, %xmm2
	vmovq	%xmm7, %rcx
	vmovsd	%xmm2, -2840(%rbp)
	vmovq	%rdi, %xmm2
	vsubsd	-6576(%rbp), %xmm2, %xmm2
	vmovq	%xmm2, %r8
	jp	.L43
	vxorpd	%xmm0, %xmm0, %xmm0
	je	.L93
.L43:
	vmovsd	.LC4(%rip), %xmm4
	vdivsd	%xmm25, %xmm4, %xmm0
.L93:
	vmulsd	%xmm0, %xmm20, %xmm0
	vaddsd	%xmm5, %xmm5, %xmm5
	vmovsd	.LC10(%rip), %xmm4
	vaddsd	%xmm19, %xmm19, %xmm19
	vaddsd	%xmm13, %xmm13, %xmm13
	vunpcklpd	%xmm0, %xmm5, %xmm5
	vandpd	.LC9(%rip), %xmm31, %xmm0
	vaddsd	%xmm12, %xmm12, %xmm12
	vaddsd	%xmm10, %xmm10, %xmm10
	vmovsd	%xmm19, 528(%r12)
	vmovsd	%xmm13, 536(%r12)
	vmovupd	%xmm5, 560(%r12)
	vmovsd	%xmm12, 544(%r12)
	vmovsd	%xmm10, 552(%r12)
	vcomisd	%xmm0, %xmm4
	jbe	.L174
	vmulsd	.LC11(%rip), %xmm31, %xmm7
	vmovsd	.LC24(%rip), %xmm3
	vmovsd	.LC18(%rip), %xmm4
	vmovsd	.LC22(%rip), %xmm8
	vmovsd	.LC16(%rip), %xmm10
	vmovsd	.LC20(%rip), %xmm6
	vmovsd	.LC14(%rip), %xmm9
	vrndscalesd	$4, %xmm7, %xmm7, %xmm7
	vmovsd	%xmm7, %xmm7, %xmm2
	vfnmadd132sd	.LC12(%rip), %xmm31, %xmm2
	vcvttsd2sil	%xmm7, %eax
	vfnmadd231sd	.LC13(%rip), %xmm7, %xmm2
	vmulsd	%xmm2, %xmm2, %xmm0
	vfnmadd213sd	.LC25(%rip), %xmm0, %xmm3
	vfmadd213sd	.LC19(%rip), %xmm0, %xmm4
	vfnmadd213sd	.LC23(%rip), %xmm0, %xmm8
	vfmadd213sd	.LC17(%rip), %xmm0, %xmm10
	vfnmadd213sd	.LC21(%rip), %xmm0, %xmm6
	vfmadd213sd	.LC15(%rip), %xmm0, %xmm9
	vmulsd	%xmm0, %xmm0, %xmm1
	vfmadd231sd	.LC27(%rip), %xmm1, %xmm3
	vfmadd231sd	.LC26(%rip), %xmm1, %xmm4
	vmulsd	%xmm0, %xmm2, %xmm5
	vfmadd132sd	%xmm1, %xmm8, %xmm3
	vfmadd132sd	%xmm1, %xmm10, %xmm4
	vfmadd132sd	%xmm1, %xmm6, %xmm3
	vfmadd132sd	%xmm1, %xmm9, %xmm4
	vmulsd	%xmm3, %xmm1, %xmm1
	vfmsub132sd	.LC28(%rip), %xmm1, %xmm0
	vfmadd132sd	%xmm4, %xmm2, %xmm5
	vmovsd	.LC4(%rip), %xmm4
	vsubsd	%xmm0, %xmm4, %xmm6
	testb	$1, %al
	jne	.L47
	vmovq	%xmm5, %rdx
	vmovsd	%xmm6, %xmm6, %xmm5
	vmovq	%rdx, %xmm6
.L47:
	testb	$2, %al
	je	.L48
	vxorpd	.LC29(%rip), %xmm6, %xmm6
.L48:
	incl	%eax
	testb	$2, %al
	je	.L46
	vxorpd	.LC29(%rip), %xmm5, %xmm5
.L46:
	vandpd	.LC9(%rip), %xmm23, %xmm0
	vmovsd	.LC10(%rip), %xmm4
	vcomisd	%xmm0, %xmm4
	jbe	.L175
	vmulsd	.LC11(%rip), %xmm23, %xmm8
	vmovsd	.LC24(%rip), %xmm7
	vmovsd	.LC18(%rip), %xmm0
	vmovsd	.LC22(%rip), %xmm10
	vmovsd	.LC16(%rip), %xmm13
	vmovsd	.LC20(%rip), %xmm9
	vmovsd	.LC14(%rip), %xmm12
	vrndscalesd	$4, %xmm8, %xmm8, %xmm8
	vmovsd	%xmm8, %xmm8, %xmm4
	vfnmadd132sd	.LC12(%rip), %xmm23, %xmm4
	vcvttsd2sil	%xmm8, %eax
	vfnmadd231sd	.LC13(%rip), %xmm8, %xmm4
	vmulsd	%xmm4, %xmm4, %xmm2
	vfnmadd213sd	.LC25(%rip), %xmm2, %xmm7
	vfmadd213sd	.LC19(%rip), %xmm2, %xmm0
	vfnmadd213sd	.LC23(%rip), %xmm2, %xmm10
	vfmadd213sd	.LC17(%rip), %xmm2, %xmm13
	vfnmadd213sd	.LC21(%rip), %xmm2, %xmm9
	vfmadd213sd	.LC15(%rip), %xmm2, %xmm12
	vmulsd	%xmm2, %xmm2, %xmm3
	vfmadd231sd	.LC27(%rip), %xmm3, %xmm7
	vfmadd231sd	.LC26(%rip), %xmm3, %xmm0
	vmulsd	%xmm2, %xmm4, %xmm1
	vfmadd132sd	%xmm3, %xmm10, %xmm7
	vfmadd132sd	%xmm3, %xmm13, %xmm0
	vfmadd132sd	%xmm3, %xmm9, %xmm7
	vfmadd132sd	%xmm3, %xmm12, %xmm0
	vmulsd	%xmm7, %xmm3, %xmm3
	vfmsub132sd	.LC28(%rip), %xmm3, %xmm2
	vfmadd132sd	%xmm0, %xmm4, %xmm1
	vmovsd	.LC4(%rip), %xmm4
	vsubsd	%xmm2, %xmm4, %xmm9
	testb	$1, %al
	jne	.L51
	vmovq	%xmm1, %rdx
	vmovsd	%xmm9, %xmm9, %xmm1
	vmovq	%rdx, %xmm9
.L51:
	testb	$2, %al
	je	.L52
	vxorpd	.LC29(%rip), %xmm9, %xmm9
.L52:
	incl	%eax
	testb	$2, %al
	je	.L50
	vxorpd	.LC29(%rip), %xmm1, %xmm1
.L50:
	vsubsd	%xmm31, %xmm31, %xmm2
	vsubsd	%xmm23, %xmm23, %xmm4
	vmulsd	%xmm6, %xmm9, %xmm0
	vfmadd231sd	-2336(%rbp), %xmm2, %xmm6
	vmovapd	-2544(%rbp), %zmm12
	xorl	%eax, %eax
	vxorpd	%xmm15, %xmm15, %xmm15
	vbroadcastsd	576(%rbx), %zmm7
	vmovapd	-3696(%rbp), %zmm11
	vmulsd	%xmm1, %xmm5, %xmm1
	vunpcklpd	%xmm4, %xmm2, %xmm3
	vmulsd	-2928(%rbp), %xmm4, %xmm4
	vunpcklpd	%xmm0, %xmm1, %xmm1
	vinsertf128	$0x1, %xmm3, %ymm1, %ymm1
	vmovupd	%ymm1, 584(%r12)
	vfmadd132sd	%xmm9, %xmm4, %xmm5
	vmovsd	-4336(%rbp), %xmm4
	vfnmadd231sd	-2352(%rbp), %xmm2, %xmm5
	vsubpd	%zmm12, %zmm12, %zmm9
	vsubsd	%xmm6, %xmm4, %xmm0
	vmovsd	-3440(%rbp), %xmm4
	vandpd	.LC9(%rip), %xmm0, %xmm10
	vsubsd	%xmm5, %xmm4, %xmm5
	vmovq	%r14, %xmm4
	vandpd	.LC9(%rip), %xmm5, %xmm6
	vcomisd	%xmm4, %xmm0
	setnb	%al
	vcvtusi2sdl	%eax, %xmm15, %xmm1
	xorl	%eax, %eax
	vmovsd	%xmm1, 656(%r12)
	vcomisd	%xmm4, %xmm5
	setnb	%al
	vcvtusi2sdl	%eax, %xmm15, %xmm1
	vmovsd	%xmm1, 664(%r12)
	vsubpd	%zmm27, %zmm27, %zmm1
	xorl	%eax, %eax
	vmulpd	632(%rbx){1to8}, %zmm9, %zmm9
	vucomisd	%xmm10, %xmm10
	setp	%al
	vmulpd	584(%rbx){1to8}, %zmm12, %zmm2
	vbroadcastsd	600(%rbx), %zmm3
	vmulpd	616(%rbx){1to8}, %zmm1, %zmm8
	vfnmadd231pd	608(%rbx){1to8}, %zmm11, %zmm9
	vfnmadd132pd	624(%rbx){1to8}, %zmm9, %zmm1
	vfnmadd231pd	-3632(%rbp), %zmm3, %zmm1
	vmulpd	592(%rbx){1to8}, %zmm27, %zmm4
	vmovsd	-2848(%rbp), %xmm11
	vfmadd132pd	%zmm27, %zmm8, %zmm7
	vfnmadd132pd	-3888(%rbp), %zmm7, %zmm3
	vcvtusi2sdl	%eax, %xmm15, %xmm7
	xorl	%eax, %eax
	vucomisd	%xmm6, %xmm6
	setp	%al
	vmovsd	%xmm7, 672(%r12)
	vucomisd	%xmm10, %xmm10
	vcvtusi2sdl	%eax, %xmm15, %xmm7
	vmovsd	%xmm7, 680(%r12)
	vmovsd	-8560(%rbp), %xmm7
	vmovq	%xmm10, %rax
	vmulsd	-2312(%rbp), %xmm7, %xmm13
	cmovp	%r14, %rax
	vucomisd	%xmm6, %xmm6
	vmulsd	-2320(%rbp), %xmm7, %xmm14
	vmovsd	-8696(%rbp), %xmm7
	vmovq	%rax, %xmm10
	movq	%rax, 704(%r12)
	vmovq	%xmm6, %rax
	cmovp	%r14, %rax
	vmovq	%rax, %xmm6
	movq	%rax, 712(%r12)
	vfmadd132sd	%xmm7, %xmm13, %xmm10
	vfmadd132sd	%xmm7, %xmm14, %xmm6
	vmovsd	%xmm10, -2312(%rbp)
	vcomisd	%xmm11, %xmm10
	ja	.L55
	vmovq	%xmm10, %rax
	vmovq	%xmm11, %rdi
	vucomisd	%xmm10, %xmm10
	cmovnp	%rdi, %rax
	movq	%rax, -2312(%rbp)
.L55:
	vmovsd	-2856(%rbp), %xmm7
	vmovsd	%xmm6, -2320(%rbp)
	vcomisd	%xmm7, %xmm6
	ja	.L56
	vmovq	%xmm6, %rax
	vmovq	%xmm7, %rdi
	vucomisd	%xmm6, %xmm6
	cmovnp	%rdi, %rax
	movq	%rax, -2320(%rbp)
.L56:
	vmovsd	-2312(%rbp), %xmm7
	vucomisd	%xmm10, %xmm7
	jp	.L114
	movq	.LC4(%rip), %rax
	vmovq	%rax, %xmm11
	je	.L57
.L114:
	vxorpd	%xmm11, %xmm11, %xmm11
.L57:
	vmovsd	-2320(%rbp), %xmm7
	vucomisd	%xmm6, %xmm7
	jp	.L115
	movq	.LC4(%rip), %rax
	vmovq	%rax, %xmm12
	je	.L59
.L115:
	vxorpd	%xmm12, %xmm12, %xmm12
.L59:
	vbroadcastsd	648(%rbx), %zmm17
	vaddpd	%zmm1, %zmm2, %zmm2
	vmovapd	-9008(%rbp), %zmm15
	vmulpd	-4144(%rbp), %zmm15, %zmm8
	vbroadcastsd	640(%rbx), %zmm18
	vmovapd	-4720(%rbp), %zmm1
	vmovsd	664(%rbx), %xmm19
	vsubpd	%zmm4, %zmm2, %zmm2
	vmovsd	672(%rbx), %xmm25
	vmovsd	680(%rbx), %xmm20
	movq	656(%rbx), %rdx
	vsubpd	%zmm2, %zmm17, %zmm4
	vsubpd	%zmm3, %zmm18, %zmm7
	vmulpd	%zmm15, %zmm1, %zmm1
	vmovapd	%zmm4, -4592(%rbp)
	vmovapd	-8944(%rbp), %zmm4
	vmulpd	696(%rbx){1to8}, %zmm4, %zmm9
	vfmadd231pd	688(%rbx){1to8}, %zmm4, %zmm8
	vmovsd	-2312(%rbp), %xmm4
	vucomisd	-2848(%rbp), %xmm4
	jp	.L61
	jne	.L61
	vmovsd	.LC28(%rip), %xmm4
	vmulsd	%xmm4, %xmm11, %xmm11
	vmovsd	%xmm11, 720(%r12)
	vmovsd	-2320(%rbp), %xmm11
	vucomisd	-2856(%rbp), %xmm11
	jp	.L65
	jne	.L65
	vmulsd	%xmm4, %xmm12, %xmm12
	vmovsd	%xmm12, 728(%r12)
.L89:
	movq	.LC4(%rip), %rax
	vmovq	%rax, %xmm11
	vmovq	%rax, %xmm4
.L91:
	vmovsd	-2312(%rbp), %xmm15
	vucomisd	%xmm10, %xmm15
	jp	.L68
	jne	.L68
	vmulsd	.LC28(%rip), %xmm11, %xmm11
.L68:
	vmovsd	-2320(%rbp), %xmm10
	vmovsd	%xmm11, 736(%r12)
	vucomisd	%xmm6, %xmm10
	jp	.L70
	jne	.L70
	vmulsd	.LC28(%rip), %xmm4, %xmm4
.L70:
	vmovsd	%xmm4, 744(%r12)
	vmovsd	-5424(%rbp), %xmm4
	vcomisd	.LC30(%rip), %xmm4
	ja	.L72
	vaddsd	-2848(%rbp), %xmm13, %xmm4
	vmovsd	%xmm4, -2312(%rbp)
	vaddsd	-2856(%rbp), %xmm14, %xmm4
	vmovsd	%xmm4, -2320(%rbp)
.L72:
	vfmadd231sd	-2928(%rbp), %xmm23, %xmm5
	vaddpd	%zmm1, %zmm9, %zmm9
	vmovsd	-2336(%rbp), %xmm4
	vmovsd	.LC4(%rip), %xmm1
	vmulsd	-2608(%rbp), %xmm4, %xmm10
	vmulsd	-2808(%rbp), %xmm4, %xmm15
	vmovsd	704(%rbx), %xmm13
	vmovsd	712(%rbx), %xmm16
	vmovsd	720(%rbx), %xmm12
	vmovsd	728(%rbx), %xmm21
	vfnmadd231sd	-2352(%rbp), %xmm31, %xmm5
	vmulsd	-2816(%rbp), %xmm4, %xmm22
	vmovsd	736(%rbx), %xmm11
	movq	744(%rbx), %rdi
	vmulsd	%xmm4, %xmm31, %xmm6
	vaddsd	%xmm6, %xmm0, %xmm0
	vucomisd	%xmm0, %xmm0
	vmovsd	%xmm5, -3440(%rbp)
	vmovsd	%xmm4, %xmm4, %xmm5
	vmulsd	-2824(%rbp), %xmm5, %xmm14
	vfmadd213sd	-2312(%rbp), %xmm10, %xmm5
	vmulsd	%xmm4, %xmm30, %xmm4
	vdivsd	%xmm5, %xmm1, %xmm1
	vmovsd	%xmm5, -2328(%rbp)
	vmovq	%r14, %xmm5
	vmovq	%xmm1, %rax
	cmovp	%r14, %rax
	vucomisd	752(%rbx), %xmm5
	vmovq	%rax, %xmm1
	jp	.L128
	jne	.L128
	vaddpd	-8624(%rbp), %zmm8, %zmm3
	vmovapd	%zmm3, -4144(%rbp)
	vaddpd	-8688(%rbp), %zmm9, %zmm3
	vmovapd	%zmm3, -4720(%rbp)
	jmp	.L76
	.p2align 4
	.p2align 3
.L79:
	vmovsd	912(%rbx), %xmm0
	vsubpd	%zmm26, %zmm24, %zmm26
	vmovsd	%xmm0, -6960(%rbp)
	vaddpd	%zmm18, %zmm29, %zmm0
	vaddpd	%zmm20, %zmm12, %zmm29
	vmovapd	%zmm0, -7024(%rbp)
	vmovapd	-3376(%rbp), %zmm0
	vsubpd	%zmm19, %zmm0, %zmm0
	vmovapd	%zmm0, -6576(%rbp)
	vsubpd	%zmm22, %zmm26, %zmm0
	vmovapd	%zmm0, -2608(%rbp)
	vxorpd	%xmm0, %xmm0, %xmm0
	jmp	.L98
	.p2align 4
	.p2align 3
.L61:
	vmovsd	-2320(%rbp), %xmm4
	vmovsd	%xmm11, 720(%r12)
	vucomisd	-2856(%rbp), %xmm4
	jp	.L65
	jne	.L65
	vmulsd	.LC28(%rip), %xmm12, %xmm12
	vmovsd	-2312(%rbp), %xmm4
	vucomisd	-2848(%rbp), %xmm4
	vmovsd	%xmm12, 728(%r12)
	jp	.L131
	je	.L89
.L131:
	movq	.LC4(%rip), %rax
	vxorpd	%xmm11, %xmm11, %xmm11
	vmovq	%rax, %xmm4
	jmp	.L91
	.p2align 4
	.p2align 3
.L65:
	vmovsd	-2312(%rbp), %xmm4
	vmovsd	%xmm12, 728(%r12)
	vucomisd	-2848(%rbp), %xmm4
	jp	.L132
	je	.L119
.L132:
	vxorpd	%xmm11, %xmm11, %xmm11
	vmovsd	%xmm11, %xmm11, %xmm4
	jmp	.L91
	.p2align 4
	.p2align 3
.L118:
	vmovapd	-8688(%rbp), %zmm4
	incq	%r10
	vmovapd	%zmm4, -4720(%rbp)
	vmovapd	-8624(%rbp), %zmm4
	vmovapd	%zmm4, -4144(%rbp)
	vxorpd	%xmm4, %xmm4, %xmm4
	vmovapd	%zmm4, -7152(%rbp)
	vmovapd	%zmm4, %zmm20
	vmovapd	%zmm4, -2992(%rbp)
	vmovapd	%zmm4, %zmm19
	vmovapd	%zmm4, -2416(%rbp)
	vmovapd	%zmm4, -2672(%rbp)
	vmovapd	%zmm4, -3120(%rbp)
	vmovapd	%zmm4, %zmm28
	vmovapd	%zmm4, -5232(%rbp)
	vmovapd	%zmm4, -5168(%rbp)
	vmovapd	%zmm4, -5104(%rbp)
	vmovapd	%zmm4, %zmm26
	vmovapd	%zmm4, -7280(%rbp)
	vmovapd	%zmm4, %zmm24
	vmovapd	%zmm4, -3184(%rbp)
	vmovapd	%zmm4, %zmm30
	vmovapd	%zmm4, -4080(%rbp)
	vmovapd	%zmm4, -4016(%rbp)
	vmovapd	%zmm4, -5040(%rbp)
	vmovapd	%zmm4, -4656(%rbp)
	vmovapd	%zmm4, -4592(%rbp)
	cmpq	%r10, -6864(%rbp)
	jnb	.L87
.L182:
	vmovsd	-8744(%rbp), %xmm4
	movq	-9144(%rbp), %r8
	vmovsd	%xmm4, (%r8)
	vmovapd	-7152(%rbp), %zmm4
	vmovupd	%zmm4, 8(%r8)
	vzeroupper
	addq	$9152, %rsp
	popq	%rbx
	popq	%r10
	.cfi_remember_state
	.cfi_def_cfa 10, 0
	popq	%r12
	popq	%r13
	popq	%r14
	popq	%r15
	popq	%rbp
	leaq	-8(%r10), %rsp
	.cfi_def_cfa 7, 8
	ret
	.p2align 4
	.p2align 3
.L119:
	.cfi_restore_state
	movq	.LC4(%rip), %rax
	vxorpd	%xmm4, %xmm4, %xmm4
	vmovq	%rax, %xmm11
	jmp	.L91
	.p2align 4
	.p2align 3
.L4:
	vmovsd	-2864(%rbp), %xmm4
	movq	-8752(%rbp), %rax
	addq	%r11, %rax
	vmovsd	%xmm4, -8744(%rbp)
	jmp	.L5
	.p2align 4
	.p2align 3
.L117:
	vxorpd	%xmm5, %xmm5, %xmm5
	vmovsd	%xmm5, %xmm5, %xmm22
	jmp	.L83
	.p2align 4
	.p2align 3
.L116:
	vxorpd	%xmm0, %xmm0, %xmm0
	vmovsd	%xmm0, -2328(%rbp)
	jmp	.L78
	.p2align 4
	.p2align 3
.L109:
	vxorpd	%xmm21, %xmm21, %xmm21
	vmovsd	%xmm21, %xmm21, %xmm25
	jmp	.L42
	.p2align 4
	.p2align 3
.L184:
	vxorpd	%xmm5, %xmm5, %xmm5
	vxorpd	%xmm20, %xmm20, %xmm20
	vmulsd	%xmm5, %xmm1, %xmm19
	vmulsd	%xmm5, %xmm2, %xmm13
	vmulsd	%xmm5, %xmm15, %xmm12
	vmulsd	%xmm5, %xmm3, %xmm10
	vmulsd	%xmm5, %xmm4, %xmm5
	jmp	.L94
	.p2align 4
	.p2align 3
.L108:
	xorl	%eax, %eax
	movq	%rax, -2328(%rbp)
	jmp	.L37
	.p2align 4
	.p2align 3
.L183:
	vxorpd	%xmm0, %xmm0, %xmm0
	vxorpd	%xmm12, %xmm12, %xmm12
	vmulsd	%xmm0, %xmm1, %xmm10
	vmulsd	%xmm0, %xmm3, %xmm9
	vmulsd	%xmm0, %xmm11, %xmm8
	vmulsd	%xmm0, %xmm5, %xmm7
	vmulsd	%xmm0, %xmm4, %xmm0
	jmp	.L96
	.p2align 4
	.p2align 3
.L107:
	vxorpd	%xmm30, %xmm30, %xmm30
	vmovsd	%xmm30, -3504(%rbp)
	jmp	.L32
	.p2align 4
	.p2align 3
.L104:
	movq	.LC2(%rip), %rax
	jmp	.L27
	.p2align 4
	.p2align 3
.L103:
	vmovsd	.LC2(%rip), %xmm2
	vmovsd	%xmm2, -3440(%rbp)
	vmovsd	%xmm2, %xmm2, %xmm26
	jmp	.L26
	.p2align 4
	.p2align 3
.L102:
	vmovsd	.LC2(%rip), %xmm2
	vmovsd	%xmm2, -4336(%rbp)
	vmovsd	%xmm2, %xmm2, %xmm0
	jmp	.L25
	.cfi_endproc
	.section	.text.unlikely
	.cfi_startproc
	.type	run.cold, @function
run.cold:
.LFSB3:
.L170:
	.cfi_escape 0xf,0x3,0x76,0x58,0x6
	.cfi_escape 0x10,0x3,0x2,0x76,0x50
	.cfi_escape 0x10,0x6,0x2,0x76,0
	.cfi_escape 0x10,0xc,0x2,0x76,0x60
	.cfi_escape 0x10,0xd,0x2,0x76,0x68
	.cfi_escape 0x10,0xe,0x2,0x76,0x70
	.cfi_escape 0x10,0xf,0x2,0x76,0x78
	vmovsd	-2352(%rbp), %xmm0
	movq	%r11, -4912(%rbp)
	movq	%r10, -4848(%rbp)
	movq	%r9, -4784(%rbp)
	movq	%rsi, -4272(%rbp)
	movq	%rcx, -4208(%rbp)
	vmovapd	%zmm20, -3952(%rbp)
	vmovapd	%zmm19, -3888(%rbp)
	vmovapd	%zmm28, -3824(%rbp)
	vmovapd	%zmm26, -3760(%rbp)
	vmovapd	%zmm24, -3696(%rbp)
	vmovapd	%zmm30, -3632(%rbp)
	vmovapd	%zmm2, -3568(%rbp)
	vmovapd	%zmm9, -3312(%rbp)
	vmovapd	%zmm21, -3056(%rbp)
	vmovapd	%zmm4, -2800(%rbp)
	movq	%r8, -2736(%rbp)
	movq	%rdi, -2480(%rbp)
	vzeroupper
	call	slow
	vmovapd	-2800(%rbp), %zmm4
	vmovapd	-3056(%rbp), %zmm21
	vmovapd	-3312(%rbp), %zmm9
	vmovsd	%xmm0, %xmm0, %xmm6
	vmovsd	%xmm1, %xmm1, %xmm3
	vmovapd	-3568(%rbp), %zmm2
	vmovapd	-3632(%rbp), %zmm30
	vmovapd	-3696(%rbp), %zmm24
	vmovapd	-3760(%rbp), %zmm26
	vmovapd	-3824(%rbp), %zmm28
	vmovapd	-3888(%rbp), %zmm19
	vmovapd	-3952(%rbp), %zmm20
	movq	-2480(%rbp), %rdi
	movq	-2736(%rbp), %r8
	movq	-4208(%rbp), %rcx
	movq	-4272(%rbp), %rsi
	movq	-4784(%rbp), %r9
	movq	-4848(%rbp), %r10
	movq	-4912(%rbp), %r11
	jmp	.L7
.L175:
	vmovsd	%xmm23, %xmm23, %xmm0
	movq	%r11, -8224(%rbp)
	movq	%r10, -8216(%rbp)
	vmovsd	%xmm26, -7664(%rbp)
	vmovapd	%zmm24, -7088(%rbp)
	movq	%r8, -7024(%rbp)
	movq	%r9, -6960(%rbp)
	movq	%rsi, -6872(%rbp)
	movq	%rcx, -6832(%rbp)
	vmovsd	%xmm29, -6576(%rbp)
	vmovsd	%xmm30, -6512(%rbp)
	vmovapd	%zmm27, -6448(%rbp)
	vmovsd	%xmm31, -6320(%rbp)
	vmovsd	%xmm6, -4656(%rbp)
	vmovsd	%xmm5, -4592(%rbp)
	vmovapd	%zmm28, -4400(%rbp)
	vmovsd	%xmm23, -2328(%rbp)
	vzeroupper
	call	slow
	vmovsd	%xmm0, %xmm0, %xmm9
	vmovsd	-2328(%rbp), %xmm23
	vmovapd	-4400(%rbp), %zmm28
	vmovsd	-4592(%rbp), %xmm5
	vmovsd	-4656(%rbp), %xmm6
	vmovsd	-6320(%rbp), %xmm31
	vmovapd	-6448(%rbp), %zmm27
	vmovsd	-6512(%rbp), %xmm30
	vmovsd	-6576(%rbp), %xmm29
	vmovapd	-7088(%rbp), %zmm24
	vmovsd	-7664(%rbp), %xmm26
	movq	-6832(%rbp), %rcx
	movq	-6872(%rbp), %rsi
	movq	-6960(%rbp), %r9
	movq	-7024(%rbp), %r8
	movq	-8216(%rbp), %r10
	movq	-8224(%rbp), %r11
	jmp	.L50
.L174:
	vmovsd	%xmm31, %xmm31, %xmm0
	movq	%r11, -7664(%rbp)
	movq	%r10, -7088(%rbp)
	vmovsd	%xmm26, -7024(%rbp)
	vmovapd	%zmm24, -6960(%rbp)
	movq	%r8, -6872(%rbp)
	movq	%r9, -6832(%rbp)
	movq	%rsi, -6576(%rbp)
	movq	%rcx, -6512(%rbp)
	vmovsd	%xmm29, -6448(%rbp)
	vmovsd	%xmm30, -6320(%rbp)
	vmovapd	%zmm27, -4656(%rbp)
	vmovsd	%xmm23, -4592(%rbp)
	vmovapd	%zmm28, -4400(%rbp)
	vmovsd	%xmm31, -2328(%rbp)
	vzeroupper
	call	slow
	vmovsd	%xmm0, %xmm0, %xmm6
	vmovsd	-2328(%rbp), %xmm31
	vmovapd	-4400(%rbp), %zmm28
	vmovsd	%xmm1, %xmm1, %xmm5
	vmovsd	-4592(%rbp), %xmm23
	vmovapd	-4656(%rbp), %zmm27
	vmovsd	-6320(%rbp), %xmm30
	vmovsd	-6448(%rbp), %xmm29
	vmovapd	-6960(%rbp), %zmm24
	vmovsd	-7024(%rbp), %xmm26
	movq	-6512(%rbp), %rcx
	movq	-6576(%rbp), %rsi
	movq	-6832(%rbp), %r9
	movq	-6872(%rbp), %r8
	movq	-7088(%rbp), %r10
	movq	-7664(%rbp), %r11
	jmp	.L46
.L173:
	vmovsd	-2824(%rbp), %xmm0
	movq	%r11, -6576(%rbp)
	movq	%r10, -6512(%rbp)
	vmovsd	%xmm16, -6448(%rbp)
	vmovapd	%zmm22, -6384(%rbp)
	vmovapd	%zmm24, -6320(%rbp)
	vmovapd	%zmm23, -6256(%rbp)
	vmovapd	%zmm9, -6192(%rbp)
	vmovapd	%zmm28, -6128(%rbp)
	vmovapd	%zmm27, -6064(%rbp)
	vmovapd	%zmm8, -6000(%rbp)
	vmovapd	%zmm10, -5936(%rbp)
	vmovapd	%zmm12, -5872(%rbp)
	vmovsd	%xmm5, -5808(%rbp)
	vmovapd	%zmm29, -5744(%rbp)
	vmovapd	%zmm4, -5424(%rbp)
	vmovapd	%zmm13, -5360(%rbp)
	vmovapd	%zmm30, -5296(%rbp)
	vmovapd	%zmm6, -4336(%rbp)
	vmovsd	%xmm3, -3888(%rbp)
	movq	%rsi, -3824(%rbp)
	movq	%r9, -3760(%rbp)
	vmovsd	%xmm31, -3504(%rbp)
	vmovapd	%zmm17, -3440(%rbp)
	movq	%r8, -3120(%rbp)
	movq	%rdi, -2928(%rbp)
	vmovsd	%xmm11, -2352(%rbp)
	vzeroupper
	call	slow
	vmovsd	%xmm1, -2336(%rbp)
	vmovsd	-2352(%rbp), %xmm11
	vmovapd	-3440(%rbp), %zmm17
	vmovsd	-3504(%rbp), %xmm31
	vmovsd	-3888(%rbp), %xmm3
	vmovapd	-4336(%rbp), %zmm6
	vmovapd	-5296(%rbp), %zmm30
	vmovapd	-5360(%rbp), %zmm13
	vmovapd	-5424(%rbp), %zmm4
	vmovapd	-5744(%rbp), %zmm29
	vmovsd	-5808(%rbp), %xmm5
	vmovapd	-5872(%rbp), %zmm12
	vmovapd	-5936(%rbp), %zmm10
	vmovapd	-6000(%rbp), %zmm8
	vmovapd	-6064(%rbp), %zmm27
	vmovapd	-6128(%rbp), %zmm28
	vmovapd	-6192(%rbp), %zmm9
	vmovapd	-6256(%rbp), %zmm23
	vmovapd	-6320(%rbp), %zmm24
	vmovapd	-6384(%rbp), %zmm22
	vmovsd	-6448(%rbp), %xmm16
	movq	-2928(%rbp), %rdi
	movq	-3120(%rbp), %r8
	movq	-3760(%rbp), %r9
	movq	-3824(%rbp), %rsi
	movq	-6512(%rbp), %r10
	movq	-6576(%rbp), %r11
	jmp	.L19
.L172:
	vmovsd	-4272(%rbp), %xmm0
	movq	%r11, -6064(%rbp)
	movq	%r10, -6000(%rbp)
	vmovapd	%zmm20, -5936(%rbp)
	vmovapd	%zmm19, -5872(%rbp)
	vmovsd	%xmm5, -5808(%rbp)
	vmovapd	%zmm12, -5744(%rbp)
	vmovapd	%zmm29, -5424(%rbp)
	vmovapd	%zmm4, -5360(%rbp)
	vmovapd	%zmm13, -5296(%rbp)
	vmovsd	%xmm3, -4336(%rbp)
	movq	%rsi, -3760(%rbp)
	vmovsd	%xmm31, -3440(%rbp)
	vmovapd	%zmm17, -2928(%rbp)
	movq	%r8, -2352(%rbp)
	movq	%rdi, -2336(%rbp)
	vmovapd	%zmm25, -4912(%rbp)
	vmovapd	%zmm27, -4848(%rbp)
	vmovsd	%xmm22, -3504(%rbp)
	vzeroupper
	call	slow
	vmovapd	-2928(%rbp), %zmm17
	vmovsd	-3440(%rbp), %xmm31
	vmovsd	-4336(%rbp), %xmm3
	vmovsd	%xmm0, %xmm0, %xmm11
	vmovsd	%xmm1, %xmm1, %xmm16
	vmovapd	-4848(%rbp), %zmm6
	vmovapd	-4912(%rbp), %zmm30
	vmovapd	-5296(%rbp), %zmm13
	vmovapd	-5360(%rbp), %zmm4
	vmovapd	-5424(%rbp), %zmm29
	vmovapd	-5744(%rbp), %zmm12
	vmovsd	-5808(%rbp), %xmm5
	vmovapd	-5872(%rbp), %zmm19
	vmovapd	-5936(%rbp), %zmm20
	movq	-2336(%rbp), %rdi
	movq	-2352(%rbp), %r8
	movq	-3504(%rbp), %r9
	movq	-3760(%rbp), %rsi
	movq	-6000(%rbp), %r10
	movq	-6064(%rbp), %r11
	jmp	.L15
.L171:
	vmovsd	-2336(%rbp), %xmm0
	movq	%r11, -5360(%rbp)
	movq	%r10, -5296(%rbp)
	movq	%r9, -4912(%rbp)
	movq	%rsi, -4848(%rbp)
	movq	%rcx, -4784(%rbp)
	vmovapd	%zmm20, -4272(%rbp)
	vmovapd	%zmm19, -4208(%rbp)
	vmovapd	%zmm28, -3952(%rbp)
	vmovapd	%zmm26, -3888(%rbp)
	vmovapd	%zmm24, -3824(%rbp)
	vmovapd	%zmm30, -3760(%rbp)
	vmovapd	%zmm2, -3696(%rbp)
	vmovapd	%zmm9, -3632(%rbp)
	vmovapd	%zmm21, -3568(%rbp)
	vmovapd	%zmm4, -3312(%rbp)
	movq	%r8, -3056(%rbp)
	movq	%rdi, -2800(%rbp)
	vmovsd	%xmm3, -2736(%rbp)
	vmovsd	%xmm6, -2480(%rbp)
	vzeroupper
	call	slow
	vmovsd	-2480(%rbp), %xmm6
	vmovsd	-2736(%rbp), %xmm3
	vmovapd	-3312(%rbp), %zmm4
	vmovsd	%xmm1, %xmm1, %xmm7
	vmovapd	-3568(%rbp), %zmm21
	vmovapd	-3632(%rbp), %zmm9
	vmovapd	-3696(%rbp), %zmm2
	vmovapd	-3760(%rbp), %zmm30
	vmovapd	-3824(%rbp), %zmm24
	vmovapd	-3888(%rbp), %zmm26
	vmovapd	-3952(%rbp), %zmm28
	vmovapd	-4208(%rbp), %zmm19
	vmovapd	-4272(%rbp), %zmm20
	movq	-2800(%rbp), %rdi
	movq	-3056(%rbp), %r8
	movq	-4784(%rbp), %rcx
	movq	-4848(%rbp), %rsi
	movq	-4912(%rbp), %r9
	movq	-5296(%rbp), %r10
	movq	-5360(%rbp), %r11
	jmp	.L11
	.cfi_endproc
.LFE3:
	.text
	.size	run, .-run
	.section	.text.unlikely
	.size	run.cold, .-run.cold
.LCOLDE32:
	.text
.LHOTE32:
	.set	.LC1,.LC7
	.section	.rodata.cst8,"aM",@progbits,8
	.align 8
.LC2:
	.long	0
	.long	2146959360
	.set	.LC3,.LC29
	.align 8
.LC4:
	.long	0
	.long	1072693248
	.align 8
.LC5:
	.long	-350469331
	.long	1057634018
	.section	.rodata
	.align 64
.LC7:
	.long	1202590843
	.long	1065646817
	.long	1202590843
	.long	1065646817
	.long	1202590843
	.long	1065646817
	.long	1202590843
	.long	1065646817
	.long	1202590843
	.long	1065646817
	.long	1202590843
	.long	1065646817
	.long	1202590843
	.long	1065646817
	.long	1202590843
	.long	1065646817
	.section	.rodata.cst8
	.align 8
.LC8:
	.long	-2131586541
	.long	1050042015
	.section	.rodata.cst16,"aM",@progbits,16
	.align 16
.LC9:
	.long	-1
	.long	2147483647
	.long	0
	.long	0
	.section	.rodata.cst8
	.align 8
.LC10:
	.long	0
	.long	1090021888
	.align 8
.LC11:
	.long	1841940611
	.long	1071931184
	.align 8
.LC12:
	.long	1413754136
	.long	1073291771
	.align 8
.LC13:
	.long	856972295
	.long	1016178214
	.align 8
.LC14:
	.long	286331153
	.long	1065423121
	.align 8
.LC15:
	.long	1431655765
	.long	-1077586603
	.align 8
.LC16:
	.long	-1521039564
	.long	1053236707
	.align 8
.LC17:
	.long	436314138
	.long	-1087766112
	.align 8
.LC18:
	.long	329805065
	.long	1038488134
	.align 8
.LC19:
	.long	1744127204
	.long	-1101339067
	.align 8
.LC20:
	.long	381774871
	.long	1062650220
	.align 8
.LC21:
	.long	1431655765
	.long	1067799893
	.align 8
.LC22:
	.long	-1216831652
	.long	1049787983
	.align 8
.LC23:
	.long	436314138
	.long	1056571808
	.align 8
.LC24:
	.long	-1463780195
	.long	1034500468
	.align 8
.LC25:
	.long	-268904296
	.long	1042411224
	.align 8
.LC26:
	.long	-416040929
	.long	-1117067277
	.align 8
.LC27:
	.long	-416040929
	.long	1026222067
	.set	.LC28,.LC31
	.section	.rodata.cst16
	.align 16
.LC29:
	.long	0
	.long	-2147483648
	.long	0
	.long	0
	.section	.rodata.cst8
	.align 8
.LC30:
	.long	1202590843
	.long	1066695393
	.section	.rodata
	.align 64
.LC31:
	.long	0
	.long	1071644672
	.long	0
	.long	1071644672
	.long	0
	.long	1071644672
	.long	0
	.long	1071644672
	.long	0
	.long	1071644672
	.long	0
	.long	1071644672
	.long	0
	.long	1071644672
	.long	0
	.long	1071644672
	.ident	"GCC: (Debian 12.2.0-14+deb12u1) 12.2.0"
	.section	.note.GNU-stack,"",@progbits
